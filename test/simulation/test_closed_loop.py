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

import numpy as np
import pytest

from uav_tracking_mpc.dynamics.frames import wrap_angle
from uav_tracking_mpc.report.metrics import metrics
from uav_tracking_mpc.settings.configuration import load_configuration
from uav_tracking_mpc.settings.simulator import SimulatorParameters
from uav_tracking_mpc.simulation import closed_loop
from uav_tracking_mpc.simulation.closed_loop import ClosedLoop, simulate
from uav_tracking_mpc.simulation.plants import SimulationError
from uav_tracking_mpc.simulation.plants.vehicle import HeldPlant, VehiclePlant

SLOW = SimulatorParameters(initial_speed=4.0)
BUDGET = "nmpc_controller.solve_time_max=5.0"
NEAR = (  # the orbit
    "uav_simulator.initial_position=[300.0, 0.0, 120.0]",
    "uav_simulator.initial_heading=1.57",
)


def flight(name, *overrides, scenario=None):
    return simulate(load_configuration(name, overrides, scenario))


@pytest.mark.parametrize(
    ("model", "after_10_s", "after_20_s", "cost", "altitude", "range_"),
    [
        (
            "exact",
            [186.470, 0.0250, 43.953, 0.3279, 5.3815],
            [150.842, 1.3476, 49.951, 0.0118, 4.0044],
            618.65,
            16.0,
            20.0,
        ),
        (
            "paper",
            [188.197, 0.0206, 38.142, 0.3672, 5.9172],
            [151.660, 1.2484, 49.915, 0.0282, 4.0096],
            701.37,
            18.0,
            21.0,
        ),
    ],
)
def test_the_published_simulation_to_the_printed_digits(
    model, after_10_s, after_20_s, cost, altitude, range_, weights
):
    """Section 6, Euler plant, N = 10; the numbers were verified independently."""
    log = flight("paper", f"nmpc_controller.model={model}")
    half_digit = [6e-4, 6e-5, 6e-4, 6e-5, 6e-5]
    assert np.all(np.abs(log.relative[10] - after_10_s) < half_digit)
    assert np.all(np.abs(log.relative[20] - after_20_s) < half_digit)
    q, r = weights
    inputs = log.inputs - log.steady_inputs
    stage_costs = np.einsum("ki,ij,kj->k", log.error[:-1], q, log.error[:-1]) + np.einsum(
        "ki,ij,kj->k", inputs, r, inputs
    )
    assert np.sum(stage_costs) == pytest.approx(cost, abs=6e-3)
    assert np.all(np.diff(log.cost) <= 1e-9)  # V_N falls at every step
    numbers = metrics(log)
    settling = numbers["settling_s"]
    assert (settling["altitude"], settling["range"]) == (altitude, range_)
    assert numbers["steady_state"]["range_rms_m"] < 1e-6
    assert log.failures == 0


def test_exact_model_holds_the_orbit_on_the_true_vehicle():
    numbers = metrics(flight("paper", "mission.plant=vehicle", "mission.duration=90"))
    settling, steady = numbers["settling_s"], numbers["steady_state"]
    assert settling["altitude"] <= 20.0 and settling["range"] <= 25.0
    assert max(steady["range_rms_m"], steady["altitude_rms_m"]) <= 0.05
    assert numbers["solver"]["failures"] == 0


@pytest.mark.parametrize("direction", ["clockwise", "counter_clockwise"])
def test_orbits_across_the_half_turn_are_flown_without_a_jump(direction):
    """Heading and azimuth cross +-pi in every orbit; no command may notice."""
    log = flight(
        "paper",
        "mission.plant=vehicle",
        "mission.duration=130",
        "nmpc_controller.range=60.0",
        "nmpc_controller.altitude=30.0",
        "nmpc_controller.airspeed=8.0",
        f"nmpc_controller.direction={direction}",
        "nmpc_controller.control_rate=5.0",
    )
    x, y, _, heading, _, _ = log.vehicle[log.time > 40.0].T
    for angle in (np.arctan2(y, x), heading):
        assert np.sum(np.abs(np.diff(angle)) > np.pi) >= 2
    late = log.command_time > 40.0
    assert np.max(np.abs(np.diff(log.inputs[late], axis=0))) < 1e-3


def test_paper_model_leaves_a_range_offset_on_the_true_vehicle():
    """(11) turns too slowly: it holds the vehicle outside the orbit."""
    told = "mission.plant=vehicle", "nmpc_controller.model=paper", "mission.duration=110"
    log = flight("paper", *told)
    late = log.error[log.time > 100.0, 0]
    assert (np.mean(late), np.std(late)) == pytest.approx((0.0284, 0.0), abs=5e-4)


def test_the_small_aircraft_settles_on_its_orbit_within_its_limits():
    """Bank, airspeed, path angle and height of the flown states; the start is inside them."""
    log = flight("small_uav", "mission.duration=40", BUDGET)
    counts = log.commands
    assert (log.failures, counts.sent, counts.plan_reused, counts.failsafe) == (0, 800, 0, 0)
    assert np.max(np.abs(log.error[log.time > 20.0, 0])) < 10.0
    assert np.max(np.abs(log.error[-1, [0, 2, 3, 4]])) < 5e-3
    envelope, (x, y, z, psi, chi, v) = log.tracking.envelope, log.vehicle.T
    turn = np.gradient(np.unwrap(psi), log.time)
    assert np.all(np.abs(turn) * v / 9.80665 < np.tan(envelope.bank_max) * 1.02)
    assert envelope.airspeed_min <= v.min() and v.max() <= envelope.airspeed_max
    # Gradients and lags: the limits hold at the plan's stages, 0.5 s apart.
    assert envelope.path_angle_min - 0.01 < chi.min() and chi.max() < envelope.path_angle_max + 0.01
    assert z.min() > envelope.height_min
    assert np.min(np.sqrt(x**2 + y**2 + z**2)) > envelope.distance_min
    force = 9.80665 * np.sin(chi[:-1]) + np.diff(v) / np.diff(log.time)
    assert force.max() < 1.01 * 3.0 and force.min() > 1.01 * -1.5


def test_on_a_long_way_the_small_aircraft_keeps_its_height_and_airspeed():
    """Against the wind from 1.5 km: a minute straight ahead, 20 m below the wanted altitude."""
    far = "uav_simulator.initial_position=[1500.0, 0.0, 100.0]"
    told = far, "mission.duration=80.0", BUDGET
    states = simulate(load_configuration("small_uav", told, "wind")).vehicle
    assert states[:, 2].min() > 80.0
    assert states[-1, 2] == pytest.approx(120.0, abs=1.0)
    assert states[:, 5].max() < 1.18 * 22.0  # the band of 17 %
    assert states[:, 5].min() > 0.98 * 22.0


def test_the_small_aircraft_follows_a_target_in_wind():
    """Target at 5 m/s, wind of 8 m/s with gusts, measured with noise and gaps."""
    log = flight(
        "small_uav",
        "mission.duration=40",
        "nmpc_controller.solve_time_max=5.0",
        "nmpc_controller.target_noise=1.0",
        "uav_simulator.wind=[8.0, 0.0, 0.0]",
        "uav_simulator.gust_intensity=1.0",
        "target_publisher.motion=line",
        "target_publisher.speed=5.0",
        "target_publisher.noise=1.0",
        "target_publisher.dropout=0.2",
    )
    late = log.error[log.time > 20.0, 0]
    assert np.max(np.abs(late)) < 15.0 and np.sqrt(np.mean(late**2)) < 5.0
    assert log.commands.failsafe == 0


@pytest.mark.parametrize("dead_times", [[0.1, 0.65, 0.1], [0.6, 0.2, 0.1], [0.17, 0.2, 0.7]])
def test_a_channel_that_answers_late_makes_no_other_one_swing_with_each_command(dead_times):
    """One of them went to and fro by 0.12 to 2.7 of its unit from a command to the next."""
    lags = [0.5, 0.3, 0.3] if dead_times[0] == 0.1 else [0.3, 0.13, 0.16]
    overrides = [f"{node}.dead_time={dead_times}" for node in ("nmpc_controller", "uav_simulator")]
    overrides += [f"{node}.rate_lag={lags}" for node in ("nmpc_controller", "uav_simulator")]
    overrides += ["nmpc_controller.response_estimation=false", "mission.duration=30.0"]
    log = simulate(load_configuration("small_uav", overrides))
    changes = np.diff(log.inputs, axis=0)
    there_and_back = np.minimum(np.abs(changes[1:]), np.abs(changes[:-1]))
    there_and_back *= changes[1:] * changes[:-1] < 0.0
    assert np.all(there_and_back.max(axis=0) < 0.08)
    assert abs(log.error[-1][0]) < 0.5


def test_bearing_error_near_the_half_turn_is_flown_through():
    """Started flying straight away from where it should: theta error close to pi."""
    log = flight(
        "paper",
        "mission.plant=vehicle",
        "uav_simulator.initial_heading=1.5",
        "uav_simulator.initial_speed=4.0",
        "mission.duration=80",
    )
    assert abs(log.error[-1, 0]) < 1.0
    assert abs(float(wrap_angle(log.relative[-1, 1] - np.pi / 2))) < 0.05


HARD_DAY = [
    "mission.plant=vehicle",
    "mission.duration=30",
    "uav_simulator.initial_speed=4.0",
    "uav_simulator.wind=[0.6, -0.3, 0.0]",
    "uav_simulator.gust_intensity=1.0",
    "uav_simulator.rate_lag=[0.3, 0.13, 0.16]",
    "uav_simulator.dead_time=[0.17, 0.2, 0.1]",
    "uav_simulator.position_noise=1.0",
    "uav_simulator.attitude_noise=0.01",
    "uav_simulator.airspeed_noise=0.1",
    "target_publisher.dropout=0.3",
    "target_publisher.delay=0.3",
    "target_publisher.noise=1.0",
]


def test_wind_lag_noise_and_dropouts_are_flown_and_reproducible():
    log, again = flight("paper", *HARD_DAY), flight("paper", *HARD_DAY, "mission.duration=10")
    ticks = len(again.vehicle)
    np.testing.assert_array_equal(log.vehicle[:ticks], again.vehicle)
    assert log.command_time[0] == pytest.approx(0.3)  # before, no target was known
    travelled = np.gradient(log.vehicle[:, :3], log.time, axis=0)
    error = travelled - log.ground_velocity
    assert np.sqrt(np.mean(error**2)) < 0.05  # between the samples there are gusts
    assert np.abs(log.error[-1, 0]) < 40.0  # a controller that knows no wind is not lost in it
    other = flight("paper", *HARD_DAY, "mission.duration=10", "uav_simulator.seed=1")
    assert not np.allclose(log.vehicle[ticks - 1], other.vehicle[-1])


def test_a_target_that_is_never_seen_is_said():
    with pytest.raises(SimulationError, match=r"never seen in 5 s: see target_publisher.dropout"):
        flight(
            "paper", "mission.plant=vehicle", "mission.duration=5", "target_publisher.dropout=1.0"
        )


SLIPPING = """
from dataclasses import replace

from uav_tracking_mpc.dynamics.frames import wrap_angle
from uav_tracking_mpc.simulation.plants.vehicle import VehiclePlant


class Slipping(VehiclePlant):
    name = "slipping"

    @property
    def truth(self):
        truth = super().truth
        return replace(truth, heading=float(wrap_angle(truth.heading - 0.2 * truth.turn_rate)))
"""


def test_a_plant_of_ones_own_is_one_file(tmp_path):
    """The nose points outside the turn; the controller takes the difference for wind."""
    file = tmp_path / "slipping.py"
    file.write_text(SLIPPING)
    own = f"mission.plant={file}:Slipping"
    log = flight("small_uav", own, "mission.duration=25", *NEAR, BUDGET)
    assert log.plant == "slipping"
    slip = wrap_angle(log.vehicle[-1, 3] - log.course[-1])
    assert float(slip) == pytest.approx(-0.2 * log.inputs[-1, 0], abs=2e-3)
    assert np.max(np.abs(log.error[log.time > 20.0, 0])) < 1.0


class Diverging(VehiclePlant):
    name = "diverging"

    @property
    def truth(self):
        if self.time > 1.0:
            self.state[2] = np.nan
        return super().truth


def test_a_plant_that_is_not_finite_ends_the_flight(monkeypatch):
    monkeypatch.setattr(closed_loop, "plant_of", lambda configuration: Diverging(SLOW))
    with pytest.raises(SimulationError, match=r"at 1.05 s the plant's position is .*nan"):
        flight("paper", "mission.plant=vehicle", "mission.duration=5")


def test_a_law_is_flown_by_the_same_loop():
    log = flight("small_uav", "mission.duration=20", "nmpc_controller.law=l1", *NEAR)
    counts = log.commands
    assert (log.solver, log.failures, counts.sent, counts.failsafe) == ("none", 0, 400, 0)
    assert np.max(np.abs(log.error[log.time > 15.0, 0])) < 1.0
    assert log.nominal.all()


def test_commands_that_were_not_asked_for_are_told_from_the_others():
    """A target seen once a second, and lost after half a second, is circled by the loiter law."""
    late = "nmpc_controller.target_timeout=0.475", "target_publisher.rate=1"
    log = flight("small_uav", "mission.duration=4", "nmpc_controller.law=l1", *late)
    np.testing.assert_array_equal(log.nominal, log.command_time % 1.0 < 0.475)


def test_a_disturbance_reaches_the_plant_and_not_the_record():
    """The turn of 0.1 s is flown on top of the commands, which answer it only later."""
    quiet = load_configuration("paper", ["mission.duration=2", "mission.plant=vehicle"])

    def pulse(time):
        return np.array([0.5 if 0.99 < time < 1.05 else 0.0, 0.0, 0.0])

    flown, disturbed = simulate(quiet), simulate(quiet, disturbance=pulse)
    before = flown.command_time < 1.05
    np.testing.assert_array_equal(flown.inputs[before], disturbed.inputs[before])
    assert np.any(flown.inputs[~before] != disturbed.inputs[~before])
    *_, heading, _, _ = (disturbed.vehicle - flown.vehicle)[flown.time < 1.12][-1]
    assert heading == pytest.approx(0.05, rel=0.02)


HOLDS = ("nmpc_controller.autopilot_holds=true", "mission.plant=held")


def test_an_autopilot_that_holds_altitude_and_airspeed_is_flown_by_its_bank():
    """Whose time constants are not those that the controller is told, 5 s."""
    slowness = "uav_simulator.hold_time=[8.0, 1.0, 8.0]", "mission.duration=95"
    log = flight("small_uav", *HOLDS, *slowness, BUDGET, scenario="crosswind")
    assert np.abs(log.error[log.time > 80.0][:, [0, 2]]).max() < 0.05  # m of range and altitude
    assert metrics(log)["settling_s"]["range"] < 30.0
    assert log.nominal.all()


def test_no_two_loops_hold_the_altitude():
    """What the controller expects of the autopilot is what that does."""
    wanted = []

    class Watched(HeldPlant):
        def inputs(self):
            flown, commanded = super().inputs(), self.plan.inputs(self.time)
            if commanded is not None and self.time > 2.0:
                wanted.append((flown[1] - commanded[1], flown[2] - commanded[2]))
            return flown

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(closed_loop, "plant_of", lambda each: Watched(each.simulator))
        flight("small_uav", *HOLDS, BUDGET, "mission.duration=20.0", scenario="still")
    np.testing.assert_array_less(np.abs(wanted).max(axis=0), [0.01, 0.02])  # rad/s, m/s^2


def loop_of_a_law(*overrides):
    return ClosedLoop(load_configuration("small_uav", ["nmpc_controller.law=l1", *overrides]))


def flown(loop, seconds):
    """Ticks of the next seconds."""
    end = loop.time + seconds
    return [loop.tick() for _ in range(round((end - loop.time) * loop.rate))]


def test_a_loop_that_is_stepped_is_the_flight_of_simulate():
    configuration = load_configuration("small_uav", ["mission.duration=5", BUDGET], "gusts")
    loop = ClosedLoop(configuration)
    ticks = flown(loop, 5.0)
    stepped, whole = loop.log(5.0), simulate(configuration)
    again = loop.log(5.0)  # asked for twice it is the same
    for record in (stepped, again):
        np.testing.assert_array_equal(record.vehicle, whole.vehicle)
        np.testing.assert_array_equal(record.inputs, whole.inputs)
    np.testing.assert_array_equal([tick.time for tick in ticks], whole.time[:-1])
    np.testing.assert_array_equal([tick.truth.position for tick in ticks], whole.vehicle[:-1, :3])


def test_errors_count_from_the_orbit_that_was_asked_for_at_each_time():
    loop = loop_of_a_law(*NEAR)
    flown(loop, 10.0)
    loop.controller.change(range=250.0)
    flown(loop, 30.0)
    log = loop.log(40.0)
    assert [(time, orbit.range) for time, orbit in log.orbits] == [(0.0, 300.0), (10.0, 250.0)]
    assert np.abs(log.error[[199, -1], 0]).max() < 1.0
    assert log.orbit.range == 250.0


def test_a_reset_puts_the_aircraft_back_and_leaves_time_and_target():
    loop = loop_of_a_law(*NEAR)
    flown(loop, 3.0)
    loop.target.go_to(loop.time, (40.0, 0.0, 0.0))
    flown(loop, 20.0)
    loop.reset()
    assert loop.time == 23.0
    first, *_, last = flown(loop, 30.0)
    np.testing.assert_array_equal(
        first.truth.position, loop.configuration.simulator.initial_position
    )
    assert first.measured.stamp == pytest.approx(23.0)
    assert np.linalg.norm(last.truth.position - [40.0, 0.0, 0.0]) == pytest.approx(300.0, abs=1.0)


def test_a_new_controller_knows_nothing_and_flies_on():
    loop = loop_of_a_law()
    flown(loop, 3.0)
    loop.controller.change(range=250.0)
    loop.restart_controller()
    assert not loop.controller.flying
    assert loop.controller.parameters.range == 300.0
    assert all(tick.command is not None for tick in flown(loop, 1.0)[2:])


def test_a_flight_is_the_same_however_short_the_budget_of_a_live_solve_is():
    """As on a machine too busy for any solve: half of the paper's solves need more than 0.1 ms."""
    logs = []
    for budget in ("0.0001", "10"):
        overrides = [f"nmpc_controller.solve_time_max={budget}", "mission.duration=5"]
        loop = ClosedLoop(load_configuration("paper", overrides))
        while loop.time < 5.0:
            if loop.time == 2.0:
                loop.controller.change(range=160.0)  # sets the budget again
            loop.tick()
        logs.append(loop.log(5.0))
    assert [log.failures for log in logs] == [0, 0]
    np.testing.assert_array_equal(logs[0].inputs, logs[1].inputs)


@pytest.mark.parametrize("late", [pytest.param(0.45, marks=pytest.mark.long), 0.9])
def test_a_state_later_than_a_segment_is_flown_by_all_the_same(late):
    """Its command is the plan's first input, whose segment by the stamp is over; not the second."""
    settings = f"uav_simulator.state_delay={late}", "nmpc_controller.state_timeout=1.0"
    wind = "uav_simulator.wind=[6.0, 2.0, 0.0]"
    loop = ClosedLoop(load_configuration("small_uav", [*settings, *NEAR, wind]))
    while loop.time < 40.0:
        loop.tick()
    log = loop.log(loop.time)
    assert np.abs(log.error[log.time > 30.0, 0]).max() < 0.05
