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

"""From a measurement to a command."""

from dataclasses import replace

import numpy as np
import pytest
from controller_cases import FLIGHT, Constant, words

from uav_tracking_mpc.control.controller import Controller
from uav_tracking_mpc.control.event import Level
from uav_tracking_mpc.control.fallback import FallbackMode
from uav_tracking_mpc.dynamics.orbit import CLOCKWISE
from uav_tracking_mpc.estimation.measurement import Measurement, MeasurementError
from uav_tracking_mpc.estimation.state_gate import REPEATING
from uav_tracking_mpc.laws import GUIDANCE_LAW, GuidanceLaw
from uav_tracking_mpc.laws.vector_field import VectorField
from uav_tracking_mpc.parameters.specification import ParameterError

TICK = 0.05
STILL = np.zeros(3)
BACK = np.pi / 2.0  # rad, heading of an aircraft that is another way round elsewhere


def measured(time, position=(300.0, 0.0, 120.0), heading=-np.pi / 2.0, wind=STILL, **more):
    """On the clockwise orbit of the small aircraft, or elsewhere."""
    position = np.array(position, dtype=float)
    air = 22.0 * np.array([np.cos(heading), np.sin(heading), 0.0])
    return Measurement(time, position, air + wind, heading, 0.0, **{"airspeed": 22.0, **more})


@pytest.fixture
def constant():
    """A controller whose plan is always the same."""
    formulation = Constant(np.array([-0.08, 0.0, 0.0]))
    return Controller(replace(FLIGHT, control_rate=10.0), formulation, stopwatch=lambda: 0.0)


@pytest.fixture
def seeing(constant):
    """It has seen the target."""
    constant.see_target(0.0, STILL)
    return constant


@pytest.fixture
def flying(seeing):
    """It has answered a state, too."""
    assert seeing.step(measured(0.0), 0.0) is not None
    return seeing


def test_without_a_target_there_is_no_command_and_that_is_said_once(constant):
    assert [constant.step(measured(k * TICK), k * TICK) for k in range(5)] == [None] * 5
    assert constant.modes.reason == "no target position"
    assert constant.modes.counts[FallbackMode.SILENCE] == 5
    assert constant.events.take() == []  # it was silent before


def test_commands_keep_the_control_rate(seeing):
    answers = [seeing.step(measured(k * TICK), k * TICK) for k in range(8)]
    assert [answer is not None for answer in answers] == [True, False] * 4
    assert answers[2].stamp == 2 * TICK
    np.testing.assert_array_equal(answers[0].inputs, seeing.formulation.plan)


def test_a_clock_that_stands_ahead_puts_no_command_into_the_future(seeing):
    sent = []
    seeing.navigator.commanded = lambda stamp, delay, *plan: sent.append(delay)
    assert seeing.step(measured(0.0), 0.02) is not None
    assert seeing.step(measured(0.1), 3600.0) is not None
    assert sent == [0.02, seeing.parameters.state_timeout]


def test_a_target_that_was_never_lost_but_forgotten_leaves_the_wings_level(flying):
    flying.navigator.target.reset()
    command = flying.step(measured(0.1, path_angle_rate=0.1), 0.1)
    assert (command.mode, command.reason) == (FallbackMode.HOLD, "no target position")


def test_a_target_of_another_clock_is_refused(flying):
    with pytest.raises(ValueError, match=r"3600.000 s ahead of the vehicle's, may be .*clocks"):
        flying.see_target(3600.0, STILL)
    with pytest.raises(ValueError, match="must be three finite numbers"):
        flying.see_target(0.1, [np.nan, 0.0, 0.0])


def test_one_stamp_that_is_ahead_does_not_blind_the_track(constant):
    for tick in range(100):
        constant.see_target(tick * TICK, STILL)
        constant.step(measured(tick * TICK), tick * TICK)
    with pytest.raises(MeasurementError, match=r"4.800 s ahead of the vehicle's, may be 0.5 s"):
        constant.see_target(99 * TICK + 4.8, STILL)
    constant.see_target(100 * TICK, STILL)
    assert constant.navigator.target.time == 100 * TICK


def test_while_a_state_only_repeats_itself_the_latest_plan_is_flown_on_and_then_it_is_lost(flying):
    hanging, modes = measured(0.1, (300.0, -2.2, 120.0)), []
    for tick in range(100):
        stamp = 0.1 + tick * TICK
        flying.see_target(stamp, STILL)
        command = flying.step(replace(hanging, stamp=stamp), stamp)
        modes += [] if command is None else [(stamp, command.mode, command.reason)]
    stamps, found, reasons = zip(*modes, strict=True)
    planned = found.count(FallbackMode.OPTIMAL)
    assert found == (FallbackMode.OPTIMAL,) * planned + (FallbackMode.EARLIER_PLAN,) * (
        len(found) - planned
    )
    assert stamps[planned] == pytest.approx(0.1 + REPEATING, abs=0.11)
    assert stamps[-1] == pytest.approx(
        stamps[planned - 1] + flying.parameters.plan_age_max, abs=0.11
    )
    assert reasons[-1] == "the vehicle state repeats itself"
    assert flying.step(replace(hanging, stamp=5.2, heading=1.0), 5.2).mode is FallbackMode.OPTIMAL


def test_targets_go_on_while_no_state_comes(constant):
    constant.step(measured(0.0), 0.0)
    for tick in range(60):
        assert constant.see_target(tick * TICK, STILL)


def test_an_answer_that_comes_too_late_was_never_given():
    clock = iter([0.0, 0.0, 1.0, 3.0, 4.0, 4.0])
    plan = Constant(np.array([-0.08, 0.0, 0.0]))
    controller = Controller(FLIGHT, plan, stopwatch=lambda: next(clock))
    controller.see_target(0.0, STILL)
    assert controller.step(measured(0.0), 0.0) is not None
    assert controller.step(measured(0.1), 0.1) is None
    assert controller.modes.mode is FallbackMode.SILENCE
    assert controller.modes.reason == "the own solve is late"
    assert "answered only after 2.000 s" in words(controller)[-2]
    assert controller.modes.counts[FallbackMode.OPTIMAL] == 1
    plan.converges = False
    assert controller.step(measured(0.2), 0.2).mode is FallbackMode.LOITER  # no earlier plan


def test_periods_of_silence_are_not_missed(flying):
    flying.fall_silent("vehicle state is lost")
    flying.see_target(600.0, STILL)
    for tick in range(10):
        flying.step(measured(600.0 + tick * TICK), 600.0 + tick * TICK)
    assert flying.modes.mode is FallbackMode.OPTIMAL
    assert (flying.rate.missed, flying.rate.late) == (0, 0)


def test_where_no_law_has_an_answer_level_flight_is_flown_and_said(constant, monkeypatch):
    monkeypatch.setattr(VectorField, "inputs", lambda *_: np.full(3, np.nan))
    constant.formulation.converges = False
    constant.see_target(0.0, STILL)
    for tick in range(5):
        command = constant.step(measured(2 * tick * TICK), 2 * tick * TICK)
        assert command.mode is constant.modes.mode is FallbackMode.HOLD
        assert "three finite numbers" in command.reason
    assert constant.modes.changes == 1
    assert constant.modes.counts[FallbackMode.HOLD] == 5
    np.testing.assert_array_equal(command.inputs, [[0.0, 0.0, 0.0]])


def test_an_old_target_is_circled_by_the_loiter_law(seeing):
    late = FLIGHT.target_timeout + 0.01
    command = seeing.step(measured(late), late)
    assert (command.mode, command.reason) == (FallbackMode.LOITER, "target position is lost")
    seeing.see_target(late, STILL)
    assert seeing.step(measured(late + 0.1), late + 0.1).mode is FallbackMode.OPTIMAL


def test_an_outlier_is_not_answered_and_said_so(flying):
    assert flying.step(measured(0.1, (9e3, 0.0, 0.0), BACK), 0.1) is None
    (event,) = [e for e in flying.events.take() if e.level is Level.REFUSAL]
    assert "jumped by" in event.words
    assert flying.state_time == 0.0
    assert flying.step(measured(0.1), 0.1) is not None


def test_an_aircraft_that_is_elsewhere_goes_on_about_its_target(constant):
    constant.see_target(0.0, STILL)
    assert constant.step(measured(0.0), 0.0) is not None
    elsewhere = (900.0, 0.0, 100.0)
    answers = [constant.step(measured(k * TICK, elsewhere, BACK), k * TICK) for k in range(1, 6)]
    given = [answer.mode for answer in answers if answer is not None]
    assert given
    assert set(given) == {FallbackMode.OPTIMAL}
    assert any("starting anew" in event.words for event in constant.events.take())


def test_a_position_that_jumps_while_all_else_goes_on_is_no_other_place(flying):
    answers = [flying.step(measured(k * TICK, (300.0, 0.0, 420.0)), k * TICK) for k in range(1, 10)]
    assert sum(answer is not None for answer in answers) == 4  # as many as are due
    told = " ".join(event.words for event in flying.events.take())
    assert "starting anew" not in told


def test_after_a_gap_a_position_that_jumps_is_another_place(flying):
    """Velocity and attitude that are as before tell nothing then."""
    begin = 2.0 * FLIGHT.state_timeout
    for k in range(4):
        flying.step(measured(begin + k * TICK, (2000.0, 0.0, 120.0)), begin + k * TICK)
    assert any("starting anew" in event.words for event in flying.events.take())


def test_the_airspeed_of_an_aircraft_that_is_elsewhere_is_still_measured(seeing):
    """It comes by itself, after its state; it was said that nobody measured it."""
    for k in range(12):
        stamp, there = k * TICK, ((900.0, 0.0, 120.0), BACK) if k > 5 else ()
        seeing.step(measured(stamp, *there, airspeed=None), stamp)
        seeing.see_air(stamp, 22.0)
    told = " ".join(event.words for event in seeing.events.take())
    assert "starting anew" in told
    assert "airspeed" not in told.replace("no airspeed yet", "")


def test_when_time_has_gone_back_everything_begins_anew(constant):
    constant.see_target(100.0, STILL)
    assert constant.step(measured(100.0), 100.0) is not None
    answers = []
    for k in range(6):
        constant.see_target(k * TICK, STILL)
        answers.append(constant.step(measured(k * TICK), k * TICK))
    # The target was forgotten with the rest: the wings are level until it is seen again.
    assert [answer and answer.mode for answer in answers] == [
        None, None, FallbackMode.HOLD, None, FallbackMode.OPTIMAL, None,
    ]  # fmt: skip
    assert any("starting anew" in event.words for event in constant.events.take())


def test_the_latency_is_the_age_of_the_state_and_the_time_of_the_answer():
    clock = iter(np.arange(0.0, 1e3, 0.02))
    controller = Controller(
        FLIGHT, Constant(np.array([-0.08, 0.0, 0.0])), stopwatch=lambda: float(next(clock))
    )
    controller.see_target(0.0, STILL)
    for k in range(200):
        controller.see_target(0.1 * k, STILL)
        controller.step(measured(0.1 * k), 0.1 * k + 0.03)
    assert controller.navigator.latency == pytest.approx(0.05, rel=1e-3)


def test_an_answer_that_took_too_long_is_not_given():
    clock = iter([0.0, 0.1, 0.1, 0.1 + FLIGHT.state_timeout + 1e-3])
    controller = Controller(FLIGHT, Constant(STILL), stopwatch=lambda: next(clock))
    controller.see_target(0.0, STILL)
    assert controller.step(measured(0.0), 0.0) is not None
    assert controller.step(measured(0.1), 0.1) is None
    assert "answered only after" in words(controller)[-2]


def test_without_air_data_the_wind_tells_the_airspeed_and_that_is_said_once(seeing):
    wind = np.array([5.0, 0.0, 0.0])

    def blown(time):
        seen = measured(time, wind=wind, airspeed=None)
        return replace(seen, position=seen.position + time * seen.ground_velocity)

    for k in range(10):
        seeing.see_target(0.1 * k, STILL)
        seeing.step(blown(0.1 * k), 0.1 * k)
    assert [w for w in words(seeing) if "air" in w] == [
        "airspeed is not measured: ground velocity and wind stand in for it",
        "the airspeed is not known: the orbit is flown at 23.0 m/s",
    ]
    seeing.see_air(1.0, 22.0)
    command = seeing.step(blown(1.0), 1.0)
    assert seeing.drift[0] == pytest.approx(5.0, abs=0.5)  # part may be a bias, or a gust
    assert command.present.airspeed == pytest.approx(22.0, abs=0.1)
    assert "it is used again" in words(seeing)[-1]


def test_the_first_airspeed_is_heard_after_the_first_state_and_awaited(seeing):
    """As from a simulator or a driver, which sends one after the other."""
    wind, commands = np.array([5.0, 0.0, 0.0]), []
    for k in range(8):
        commands.append(seeing.step(measured(0.1 * k, wind=wind, airspeed=None), 0.1 * k))
        seeing.see_air(0.1 * k, 22.0)
    assert commands[0] is None
    assert all(command.mode is FallbackMode.OPTIMAL for command in commands[1:])
    assert commands[1].present.airspeed == pytest.approx(22.0, abs=0.1)
    assert not [w for w in words(seeing) if "air" in w]


def test_a_target_is_ahead_only_of_a_vehicle_that_is_heard(flying):
    """A vehicle that is silent tells nothing of the clocks; once it is heard again it does."""
    late = FLIGHT.target_timeout + 1.0
    with pytest.raises(MeasurementError, match="ahead of the vehicle's"):
        flying.see_target(late, STILL)
    flying.fall_silent("vehicle state is lost")
    assert flying.see_target(late, STILL)
    for k in range(4):
        flying.see_state(measured(late + TICK * k))
    with pytest.raises(MeasurementError, match="ahead of the vehicle's"):
        flying.see_target(3.0 * late, STILL)


def test_an_airspeed_that_ends_in_flight_is_told(seeing):
    for k in range(20):
        seeing.see_target(0.1 * k, STILL)
        seeing.step(measured(0.1 * k, airspeed=None), 0.1 * k)
        if k < 5:
            seeing.see_air(0.1 * k, 22.0)
    told = [w for w in words(seeing) if "air" in w]
    assert told == [
        "the airspeed is not known: the orbit is flown at 23.0 m/s",
        "airspeed is not measured: ground velocity and wind stand in for it",
    ]


@pytest.mark.parametrize("law", ["l1", "npfg", "vector_field"])
def test_a_law_is_flown_in_the_place_of_the_predictive_controller(law):
    parameters = replace(FLIGHT, law=law, direction=CLOCKWISE)
    controller = Controller(parameters, stopwatch=lambda: 0.0)
    assert controller.formulation is None
    controller.see_target(0.0, STILL)
    command = controller.step(measured(0.0), 0.0)
    assert (command.mode, command.reason) == (FallbackMode.GUIDANCE_LAW, "")
    expected = GUIDANCE_LAW.find(law)(parameters.orbit, parameters.envelope)
    np.testing.assert_array_equal(command.inputs, [expected.inputs(command.present)])


class Broken(GuidanceLaw):
    """A law that divides by zero."""

    name = "broken"

    def inputs(self, situation):
        return np.full(3, 1 / 0)


def test_a_law_that_fails_is_replaced_by_the_loiter_law(monkeypatch):
    monkeypatch.setattr("uav_tracking_mpc.control.controller.law_of", lambda parameters: Broken)
    controller = Controller(replace(FLIGHT, law="l1"), stopwatch=lambda: 0.0)
    controller.see_target(0.0, STILL)
    command = controller.step(measured(0.0), 0.0)
    assert command.mode is FallbackMode.LOITER
    assert command.reason == "the law broken failed: ZeroDivisionError: division by zero"
    assert np.all(np.isfinite(command.inputs))


def test_a_law_that_does_not_exist_is_named():
    with pytest.raises(ParameterError, match="there is no file"):
        Controller(replace(FLIGHT, law="nowhere.py:Law"))


def test_reset_begins_anew_whatever_the_time(constant):
    constant.see_target(50.0, STILL)
    constant.step(measured(50.0), 50.0)
    constant.reset()
    assert not constant.flying
    constant.see_target(2.0, STILL)
    assert constant.step(measured(2.0), 2.0).mode is FallbackMode.OPTIMAL


def test_what_is_planned_is_flown_from_when_it_was_sent(flying):
    """A late answer: until then the aircraft flew what it had been told before."""
    flying.formulation.plan = flying.formulation.plan + np.array([0.0, 0.1, 0.0])
    flying.step(measured(0.1), 0.14)
    history = flying.navigator._history
    assert [history.demanded(time, 1) for time in (0.0, 0.13, 0.15)] == [0.0, 0.0, 0.1]


def test_a_command_says_which_orbit_is_flown_about_the_moving_target(constant):
    velocity = np.array([3.0, -1.0, 0.5])
    for k in range(3):
        constant.see_target(k * TICK, np.array([10.0, 20.0, 30.0]) + k * TICK * velocity, velocity)
        command = constant.step(measured(k * TICK, wind=np.array([2.0, 4.0, 0.0])), k * TICK)
        if command is None:
            continue
        flown = command.flown_orbit
        height = command.present.target[2] + FLIGHT.altitude
        np.testing.assert_allclose(flown.centre[:2], command.present.target[:2])
        assert flown.centre[2] == pytest.approx(height)
        np.testing.assert_allclose(flown.velocity, velocity, atol=0.3)  # the track follows
        assert flown.airspeed == FLIGHT.airspeed
        assert flown.airspeed_now == command.present.airspeed
        clockwise = constant.orbit.direction == CLOCKWISE
        assert flown.radius == pytest.approx((-1.0 if clockwise else 1.0) * FLIGHT.orbit.radius)


def test_where_the_autopilot_holds_the_loiter_law_flies_the_bank_alone():
    held = replace(FLIGHT, autopilot_holds=True, control_rate=10.0, dead_time=(0.0, 0.0, 0.0))
    controller = Controller(held, Constant(np.array([-0.08, 0.0, 0.0])), stopwatch=lambda: 0.0)
    controller.see_target(0.0, STILL)
    command = None
    for k in range(round(10.0 / TICK)):
        now = measured(k * TICK, position=(300.0, 0.0, 110.0))
        command = controller.step(now, k * TICK) or command
    assert command.mode is FallbackMode.LOITER
    model, present = held.vehicle, command.present
    state = model.initial(present.vehicle, present.target, present.rates)
    expected = model.held(state, 120.0, 22.0, model.numbers(0.4), present.drift)
    np.testing.assert_allclose(command.inputs[0, 1:], expected)
    assert command.flown_orbit.centre[2] == pytest.approx(120.0)


def test_commands_that_are_not_flown_count_for_nothing(constant):
    """They are answered all the same, but neither navigation nor estimator believes in them."""

    def turning(stamp):
        now, navigator = measured(stamp), constant.navigator
        return navigator.estimate(*navigator.air.see_state(now)).effect.rates[0]

    constant.engage(False)
    constant.see_target(0.0, STILL)
    for k in range(4):
        assert constant.step(measured(0.1 * k), 0.1 * k) is not None
    assert turning(0.4) == pytest.approx(0.0, abs=1e-3)
    assert not constant.response.enabled
    constant.engage(True)
    for k in range(4, 20):
        constant.step(measured(0.1 * k), 0.1 * k)
    assert turning(2.0) < -0.02


@pytest.mark.parametrize(("ground", "accelerates"), [(10.0, True), (40.0, False)])
def test_an_aircraft_that_two_sensors_find_too_fast_is_not_accelerated(ground, accelerates):
    controller = Controller(FLIGHT, Constant(np.array([-0.08, 0.0, 1.0])), stopwatch=lambda: 0.0)
    controller.see_target(0.0, STILL)
    state = replace(measured(0.0), ground_velocity=np.array([0.0, -ground, 0.0]), airspeed=40.0)
    assert (controller.step(state, 0.0).inputs[:, 2].max() > 0.0) == accelerates
