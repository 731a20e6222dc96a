# Copyright 2026 uav_tracking_mpc maintainers
#
# Licensed under the Apache License, Version 2.0 (the "License");
# you may not use this file except in compliance with the License.
# You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software
# distributed under the License is distributed on an "AS IS" BASIS,
# WITHOUT WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied.
# See the License for the specific language governing permissions and
# limitations under the License.

"""Wind triangle, what is flown when a command takes effect, and the forecast, against the plant."""

from dataclasses import replace

import numpy as np
import pytest
import small_uav

from uav_tracking_mpc.dynamics.frames import wrap_angle
from uav_tracking_mpc.estimation.measurement import Measurement
from uav_tracking_mpc.estimation.navigator import Navigator
from uav_tracking_mpc.settings.configuration import load_configuration
from uav_tracking_mpc.simulation.plants.vehicle import VehiclePlant

TICK = 0.05
FLIGHT = small_uav.parameters("air_estimation=false")  # what is measured counts as it is
VEHICLE = np.array([300.0, -50.0, 120.0, 2.0, 0.05, 22.0])


def measured(time, ground_velocity=(0.0, 0.0, 0.0), rates=(0.0, 0.0), vehicle=VEHICLE):
    heading, path_angle, airspeed = vehicle[3:]
    return Measurement(time, vehicle[:3], ground_velocity, heading, path_angle, *rates, airspeed)


def estimated(navigator, measurement):
    return navigator.estimate(*navigator.air.see_state(measurement))


def seen(parameters, until=6.0, start=(5.0, -3.0, 2.0), run=(0.0, 0.0, 0.0)):
    """Navigator that has seen a target in straight flight, 10 positions a second."""
    navigator = Navigator(parameters)
    for time in np.linspace(0.0, until, round(10 * until) + 1):
        navigator.target.update(time, np.array(start) + time * np.array(run))
    return navigator


def test_the_drift_is_the_wind_triangle_less_the_targets_velocity():
    wind, run = np.array([6.0, -4.0, 0.5]), np.array([3.0, 2.0, 0.0])
    navigator = seen(FLIGHT, run=run)
    air = 22.0 * np.array([np.cos(0.05) * np.cos(2.0), np.cos(0.05) * np.sin(2.0), np.sin(0.05)])
    now = estimated(navigator, measured(6.0, air + wind, (0.2, -0.1))).present
    _, velocity, acceleration = navigator.target.motion(6.0)
    np.testing.assert_allclose(now.drift, wind - velocity, atol=1e-12)
    np.testing.assert_allclose(now.drift, wind - run, atol=0.05)
    np.testing.assert_array_equal(now.drift_rate, -acceleration)
    np.testing.assert_allclose(now.target, [5.0 + 18.0, -3.0 + 12.0, 2.0], atol=0.05)
    np.testing.assert_array_equal(now.vehicle, VEHICLE)
    np.testing.assert_array_equal(now.rates, [0.2, -0.1, 0.0])  # nothing has been commanded


def test_a_later_estimate_leaves_an_earlier_one_alone():
    navigator = seen(FLIGHT)
    first = estimated(navigator, measured(6.0, (1.0, 2.0, 0.0)))
    kept = first.forecast.drift.copy(), first.present.drift.copy()
    estimated(navigator, measured(6.1, (-5.0, 2.0, 0.0)))
    np.testing.assert_array_equal(first.forecast.drift, kept[0])
    np.testing.assert_array_equal(first.present.drift, kept[1])


def test_without_a_target_there_is_no_situation():
    navigator = Navigator(FLIGHT)
    with pytest.raises(ValueError, match="no target position"):
        estimated(navigator, measured(0.0))
    navigator = seen(FLIGHT)
    navigator.reset()
    with pytest.raises(ValueError, match="no target position"):
        estimated(navigator, measured(6.0))


class Flight:
    """Plant and navigator, one command a tick: two turns, a climb and engine that vary."""

    def __init__(self, dead_time, wind=(0.0, 0.0, 0.0), run=(0.0, 0.0, 0.0)):
        lists = f"dead_time={list(dead_time)}"
        configuration = load_configuration(
            "small_uav",
            [
                f"nmpc_controller.{lists}",
                "nmpc_controller.air_estimation=false",
                f"uav_simulator.{lists}",
                f"uav_simulator.wind={list(wind)}",
            ],
        )
        self.parameters = configuration.controller
        self.plant = VehiclePlant(configuration.simulator)
        self.navigator = Navigator(self.parameters)
        self.run, self.ticks = np.array(run), 0

    @property
    def time(self):
        return self.ticks * TICK

    def fly(self, ticks, command=True):
        """Fly on; without commands what was commanded last is held."""
        for _ in range(ticks):
            if self.ticks % 2 == 0:
                self.navigator.target.update(self.time, self.time * self.run)
            estimate = self.estimate()
            if command:
                t = self.time
                turn, climb = 0.2 * np.sin(1.3 * t), 0.1 * np.cos(2.1 * t)
                # Held far longer than any delay: the last one goes on
                plan = np.tile([turn, climb, 0.8 * np.sin(0.7 * t)], (4, 1))
                self.navigator._history.add(t, t, plan, 0.5)
                self.plant.accept(plan, t + 0.5 * np.arange(4))
            self.plant.advance(TICK)
            self.ticks += 1
        return estimate

    def estimate(self):
        return estimated(self.navigator, replace(self.plant.measured(), stamp=self.time))


def test_the_acceleration_flown_is_told_from_the_commands():
    """Lag 0.16 s, dead time 0.1 s: as the plant flies it, though nothing measures it."""
    flight = Flight((0.2, 0.2, 0.1))
    for _ in range(40):
        flight.fly(1)
        told = flight.estimate().present.rates
        np.testing.assert_allclose(told, flight.plant.rates, atol=1e-12)
    assert abs(flight.plant.rates[2]) > 0.2


@pytest.mark.parametrize(
    ("dead_time", "metres"),
    [
        ((0.2, 0.2, 0.2), 1e-4),
        ((0.2, 0.15, 0.1), 1e-4),
        ((0.17, 0.2, 0.1), 5e-3),  # changes inside of a substep
    ],
)
@pytest.mark.parametrize(
    ("wind", "run"), [((0.0, 0.0, 0.0), (0.0, 0.0, 0.0)), ((7.0, -4.0, 0.0), (3.0, 2.0, 0.0))]
)
def test_a_command_is_computed_for_where_the_aircraft_is_when_it_takes_effect(
    dead_time, metres, wind, run
):
    """The plant flies through its dead time by the commands already under way."""
    flight = Flight(dead_time, wind, run)
    flight.fly(120)
    situation, later, _ = flight.estimate()
    delay = max(dead_time)
    flight.fly(round(delay / TICK), command=False)
    state, offset = flight.plant.state, flight.plant.state[:3] - flight.time * np.array(run)
    still = not np.any(run)
    position = metres if still else metres + 0.05 * delay  # by the target's estimated velocity
    np.testing.assert_allclose(later.offset, offset, atol=position)
    np.testing.assert_allclose(later.vehicle[:3], state[:3], atol=metres if still else 0.05)
    assert abs(wrap_angle(later.vehicle[3] - state[3])) < 2e-3
    np.testing.assert_allclose(later.vehicle[4:], state[4:], atol=2e-3)
    np.testing.assert_allclose(later.rates, flight.plant.rates, atol=0.03)
    if dead_time[0] == 0.2:
        np.testing.assert_allclose(later.vehicle[4:], state[4:], atol=1e-9)
        np.testing.assert_allclose(later.rates, flight.plant.rates, atol=1e-9)
    # Not to be had by chance: the aircraft moved by metres, and turned.
    assert np.linalg.norm(later.offset - situation.offset) > 2.0


def test_latency_adds_to_the_dead_time_within_limits():
    navigator = seen(FLIGHT, run=(3.0, 0.0, 0.0))
    begin = estimated(navigator, measured(6.0)).forecast.target[0, 0]
    for latency, counted in ((0.1, 0.1), (-1.0, 0.0), (1e9, FLIGHT.state_timeout), (1e-12, 0.0)):
        navigator.latency = latency
        _, later, forecast = estimated(navigator, measured(6.0))
        assert forecast.target[0, 0] - begin == pytest.approx(3.0 * counted, abs=0.01)
        np.testing.assert_array_equal(later.target, forecast.target[0])


def test_the_forecast_follows_target_and_drift_from_the_effect_on():
    wind, run = np.array([2.0, 5.0, 0.0]), np.array([3.0, -2.0, 0.0])
    navigator = seen(FLIGHT, run=run)
    air = VEHICLE[5] * np.array([np.cos(0.05) * np.cos(2.0), np.cos(0.05) * np.sin(2.0), 0.0])
    air[2] = VEHICLE[5] * np.sin(0.05)
    forecast = estimated(navigator, measured(6.0, air + wind)).forecast
    times = 6.0 + 0.2 + FLIGHT.horizon_step * np.arange(FLIGHT.horizon + 1)
    expected = np.array([5.0, -3.0, 2.0]) + times[:, np.newaxis] * run
    np.testing.assert_allclose(forecast.target, expected, atol=0.3)
    np.testing.assert_allclose(forecast.drift, np.tile(wind - run, (len(times), 1)), atol=0.05)
    np.testing.assert_allclose(forecast.drift_rate, 0.0, atol=0.05)


def test_without_delay_the_situation_is_as_measured():
    parameters = replace(FLIGHT, dead_time=(0.0, 0.0, 0.0))
    navigator = seen(parameters)
    now, later, forecast = estimated(navigator, measured(6.0))
    assert later is now
    assert forecast.target.shape == (FLIGHT.horizon + 1, 3)


def test_a_change_keeps_what_is_known_of_the_target():
    navigator = seen(FLIGHT, run=(3.0, 0.0, 0.0))
    before = navigator.target.motion(6.1)
    navigator.change(replace(FLIGHT, target_noise=2.0, target_agility=1.0))
    np.testing.assert_array_equal(navigator.target.motion(6.1), before)


@pytest.mark.parametrize(("height", "said"), [(-90.0, True), (-10.0, False), (120.0, False)])
def test_an_aircraft_far_below_its_target_is_told_once(height, said):
    navigator, words = seen(FLIGHT), []
    for time in (6.0, 6.1):
        low = replace(measured(time), position=np.array([200.0, 0.0, height]))
        estimated(navigator, low)
        words += navigator.complaints()
    told = "the aircraft is 92 m below the target: z must be positive up (ENU)"
    assert words == ([told] if said else [])


@pytest.mark.parametrize(
    ("excess", "said"), [(0.15, "too much"), (-0.15, "too little"), (0.05, "")]
)
def test_an_airspeed_that_is_corrected_by_much_is_told_once(excess, said):
    navigator = Navigator(FLIGHT)
    navigator.air_estimate.state.alpha[:] = excess
    words = [*navigator.complaints(), *navigator.complaints()]
    told = f"the airspeed reads {said} by more than 10%: it is corrected"
    assert words == ([told] if said else [])


def test_a_latency_of_next_to_nothing_is_flown_through():
    navigator = seen(replace(FLIGHT, dead_time=(0.0, 0.0, 0.0)))
    navigator.latency = 1e-12
    now, later, _ = estimated(navigator, measured(6.0))
    np.testing.assert_allclose(later.offset, now.offset, atol=1e-9)


def test_a_command_is_under_way_from_when_it_was_sent():
    navigator = seen(FLIGHT)
    plan = np.array([[0.1, 0.0, 0.0], [0.2, 0.0, 0.0]])
    navigator.commanded(6.0, 0.3, plan, 0.5)
    assert [navigator._history.demanded(time, 0) for time in (6.2, 6.4, 6.6)] == [0.0, 0.1, 0.2]
    assert navigator.latency == pytest.approx(0.05 * 0.3)


def test_without_air_data_the_velocity_over_ground_counts():
    navigator = seen(FLIGHT)
    velocity = np.array([-3.0, 4.0, 0.0])
    blind = replace(measured(6.0, velocity), airspeed=None)
    present = estimated(navigator, blind).present
    assert present.airspeed == pytest.approx(5.0)
    assert present.heading == pytest.approx(np.arctan2(4.0, -3.0))
    assert navigator.air.missing
    np.testing.assert_allclose(navigator.wind, 0.0, atol=1e-12)
    navigator.air.see(6.0 - FLIGHT.state_timeout, 21.0)
    assert estimated(navigator, blind).present.airspeed == 21.0
    assert not navigator.air.missing
    navigator.air.see(6.0 - FLIGHT.state_timeout - 1e-3, 21.0)
    assert estimated(navigator, blind).present.airspeed == pytest.approx(5.0)


def flight_in_air(overrides, until=60.0, scenario="crosswind"):
    """Estimates and truth of a circling aircraft with what its sensors get wrong."""
    configuration = load_configuration(
        "small_uav", [f"uav_simulator.{each}" for each in overrides], scenario
    )
    plant, navigator = VehiclePlant(configuration.simulator), Navigator(configuration.controller)
    found = []
    for tick in range(round(until / TICK)):
        time = plant.time = tick * TICK
        navigator.target.update(time, np.zeros(3))
        estimate = estimated(navigator, plant.measured())
        found.append((estimate, plant.truth, plant.wind))
        plan = np.array([[0.12, 0.02 * np.sin(0.3 * time), 0.2 * np.sin(0.5 * time)]])
        navigator.commanded(time, 0.0, plan, 0.5)
        plant.accept(plan, [time])
        plant.advance(TICK)
    return found


BIASES = {
    "velocity_bias=[2.0, -1.0, 0.5]": 2.0,
    "heading_bias=0.087": 1.9,
    "airspeed_bias=2.0": 2.0,
    "turn_rate_bias=0.035": 0.035,
}


@pytest.mark.parametrize("bias", BIASES)
def test_a_constant_bias_is_taken_out_of_the_situation(bias):
    """A tenth of it is left after two turns, of the wind or of the turn rate."""
    estimate, truth, wind = flight_in_air([bias], until=100.0)[-1]
    present = estimate.present
    error = present.drift - wind  # the target stands
    if bias.startswith("turn_rate"):
        assert abs(present.rates[0] - truth.turn_rate) < 0.1 * BIASES[bias]
    else:
        assert np.linalg.norm(error) < 0.1 * BIASES[bias]
    assert abs(wrap_angle(present.heading - truth.heading)) < 0.01
    assert present.airspeed == pytest.approx(truth.airspeed, abs=0.25)
    np.testing.assert_allclose(present.vehicle[:3], truth.position, atol=0.05)


def test_noise_is_smoothed_out():
    noise = ["velocity_noise=0.3", "attitude_noise=0.0087", "airspeed_noise=0.3"]
    found = flight_in_air(noise)[400:]
    drift = np.array([estimate.present.drift - wind for estimate, _, wind in found])
    heading = [wrap_angle(estimate.present.heading - truth.heading) for estimate, truth, _ in found]
    assert np.sqrt(np.mean(drift**2)) < 0.1  # 0.36 m/s in the wind triangle
    assert np.sqrt(np.mean(np.square(heading))) < 0.3 * 0.0087


def test_gusts_are_followed_and_fade_over_the_horizon():
    found = flight_in_air(["gust_intensity=15.4", "wind=[0.0, 8.0, 0.0]"], until=120.0)[400:]
    drift = np.array([estimate.present.drift - wind for estimate, _, wind in found])
    gusts = np.array([wind - [0.0, 8.0, 0.0] for _, _, wind in found])
    assert np.sqrt(np.mean(drift**2)) < 0.2 * np.sqrt(np.mean(gusts**2))
    estimate, _, _ = found[-1]
    ahead = estimate.forecast.drift
    assert np.linalg.norm(ahead[-1] - ahead[0]) > 0.1
    # What the forecast says of its own rate of change is its rate of change.
    middle = 0.5 * (estimate.forecast.drift_rate[1:] + estimate.forecast.drift_rate[:-1])
    np.testing.assert_allclose(np.diff(ahead, axis=0) / FLIGHT.horizon_step, middle, atol=2e-3)
