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

import contextlib
import math
from dataclasses import replace

import numpy as np
import pytest
import small_uav
from controller_cases import (
    FLIGHT,
    PAPER,
    estimate,
    flight_controller,
    limits,
    paper_situation,
    words,
)

from uav_tracking_mpc.control.command_shaping import FADE_TIME
from uav_tracking_mpc.control.controller import Controller
from uav_tracking_mpc.control.fallback import FallbackMode
from uav_tracking_mpc.control.guidance import formulation_of
from uav_tracking_mpc.dynamics.orbit import CLOCKWISE, COUNTER_CLOCKWISE
from uav_tracking_mpc.estimation.measurement import Measurement, MeasurementError
from uav_tracking_mpc.formulation.flight_formulation import FlightFormulation
from uav_tracking_mpc.formulation.paper_formulation import PaperFormulation
from uav_tracking_mpc.laws.vector_field import VectorField
from uav_tracking_mpc.mpc.solver import Status
from uav_tracking_mpc.parameters.specification import ParameterError
from uav_tracking_mpc.settings.configuration import load_configuration


def test_the_parameters_choose_the_formulation():
    assert isinstance(formulation_of(PAPER), PaperFormulation)
    assert isinstance(formulation_of(FLIGHT), FlightFormulation)


def test_on_the_orbit_the_steady_turn_is_commanded(controller):
    command = controller._fly(0.0, estimate(paper_situation(PAPER.orbit.steady_state)))
    assert (command.mode, command.reason) == (FallbackMode.OPTIMAL, "")
    np.testing.assert_allclose(command.inputs[0], PAPER.steady_inputs, atol=1e-6)


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_on_the_orbit_the_steady_turn_is_commanded_in_a_flight(sense):
    controller = flight_controller()
    command = controller._fly(0.0, estimate(small_uav.on_orbit(FLIGHT, 2.0, sense), FLIGHT.horizon))
    assert command.mode is FallbackMode.OPTIMAL
    assert command.orbit.direction == (COUNTER_CLOCKWISE if sense > 0.0 else CLOCKWISE)
    steady = [sense * FLIGHT.orbit.speed / FLIGHT.orbit.radius, 0.0, 0.0]
    np.testing.assert_allclose(command.inputs, np.tile(steady, (FLIGHT.horizon, 1)), atol=1e-4)


def test_command_is_the_first_of_the_plan(controller, start):
    command = controller._fly(0.0, start)
    np.testing.assert_allclose(command.inputs[0], [0.6754, 0.7854, 1.0], atol=6e-5)
    assert command.inputs.shape == (PAPER.horizon, 3)
    assert command.step == PAPER.horizon_step
    assert command.solution is command.plan.solution


def test_a_failed_solve_is_bridged_by_the_earlier_plan(controller, start):
    plan = controller._fly(10.0, start).inputs
    controller.formulation.status = Status.FAILED
    bridged = controller._fly(11.5, start)
    assert (bridged.mode, bridged.reason) == (FallbackMode.EARLIER_PLAN, "told to")
    assert words(controller)[-1] == "now flying earlier plan, before optimal plan: told to"
    np.testing.assert_array_equal(bridged.inputs, plan[1:])  # 1.5 s later the second stage runs


def test_an_earlier_plan_is_not_flown_for_ever(controller, start):
    """Then the loiter law takes over, without a jump."""
    law = VectorField(PAPER.orbit, PAPER.envelope).inputs(start.effect)
    controller._fly(0.0, start)
    controller.formulation.status = Status.FAILED
    bridged = controller._fly(2.0, start)
    assert bridged.mode is FallbackMode.EARLIER_PLAN
    late = controller._fly(2.1, start)
    assert (late.mode, late.reason) == (FallbackMode.LOITER, "told to")
    np.testing.assert_allclose(late.inputs[0], bridged.inputs[0], atol=1e-12)
    later = controller._fly(2.1 + 3.0 * FADE_TIME, start)
    left = np.exp(-3.0) * (bridged.inputs[0] - law)
    np.testing.assert_allclose(later.inputs, [law + left], atol=1e-12)


def test_after_a_failure_it_returns_to_optimal_plans(controller, start):
    controller._fly(0.0, start)
    controller.formulation.status = Status.FAILED
    assert controller._fly(5.0, start).mode is FallbackMode.LOITER
    controller.formulation.status = None
    command = controller._fly(5.1, start)
    assert (command.mode, command.reason) == (FallbackMode.OPTIMAL, "")
    assert words(controller)[-1] == "now flying optimal plan, before loiter law"


@pytest.mark.parametrize(
    "error", [ValueError("no such value"), ZeroDivisionError("by zero"), KeyError("no such part")]
)
def test_a_controller_that_breaks_is_survived_and_named(controller, start, error):
    controller._fly(0.0, start)
    controller.formulation.error = error
    command = controller._fly(0.1, start)
    assert command.mode is FallbackMode.EARLIER_PLAN
    assert command.reason == f"the controller failed: {error}"
    assert command.solution is None


@pytest.mark.parametrize("status", [Status.TIME_LIMIT, Status.ITERATION_LIMIT])
def test_an_unfinished_plan_is_flown_if_it_is_feasible(controller, start, status):
    controller.formulation.status = status
    command = controller._fly(0.0, start)
    assert (command.mode, command.reason) == (FallbackMode.FEASIBLE, "told to")
    np.testing.assert_array_equal(command.inputs, command.plan.inputs)
    controller.formulation.violation = 0.1
    assert controller._fly(0.1, start).mode is FallbackMode.EARLIER_PLAN  # the feasible one
    controller.reset()
    assert controller._fly(0.2, start).mode is FallbackMode.LOITER


def test_a_budget_that_is_too_short_still_gives_a_command():
    formulation = FlightFormulation(replace(FLIGHT, solve_time_max=1e-4), small_uav.solver())
    controller = Controller(formulation.parameters, formulation)
    now = small_uav.situation(drift=(6.0, -3.0, 0.0))
    command = controller._fly(0.0, estimate(now, FLIGHT.horizon))
    assert command.solution.status is Status.TIME_LIMIT
    assert command.mode in (FallbackMode.FEASIBLE, FallbackMode.LOITER)
    lower, upper = limits(FLIGHT, 22.0)
    assert np.all((lower <= command.inputs) & (command.inputs <= upper))


def test_without_a_fresh_target_the_law_flies(controller, start):
    command = controller._fly(0.0, start, target_fresh=False)
    assert (command.mode, command.reason) == (FallbackMode.LOITER, "target position is lost")
    assert command.plan is None


def test_reset_forgets_the_plan(controller, start):
    controller._fly(0.0, start)
    controller.reset()
    controller.formulation.status = Status.FAILED
    assert controller._fly(0.1, start).mode is FallbackMode.LOITER


def test_after_a_reset_no_orbit_is_refused_for_a_wind_of_then():
    controller = flight_controller()
    controller.drift = np.array([15.0, 0.0, 0.0])
    with pytest.raises(ParameterError, match=r"a drift of 15\.0 m/s"):
        controller.change(airspeed=15.0)
    controller.reset()
    controller.change(airspeed=15.0)
    assert controller.orbit.speed == 15.0


def test_a_drift_that_is_too_much_refuses_only_what_it_has_to_do_with():
    controller = flight_controller()
    controller.drift = np.array([21.0, 0.0, 0.0])
    with pytest.raises(ParameterError, match="a drift of 21"):
        controller.change(airspeed=21.0)
    controller.change(target_noise=0.2, state_timeout=0.7)
    assert controller.parameters.target_noise == 0.2
    controller.change(airspeed=25.0)
    assert controller.orbit.speed == 25.0


def test_without_a_target_it_levels_out(controller):
    vehicle = np.array([0.0, 0.0, 50.0, 1.0, 0.2, 4.0])
    command = controller._hold(0.0, vehicle, "no target position yet")
    assert (command.mode, command.reason) == (FallbackMode.HOLD, "no target position yet")
    np.testing.assert_allclose(command.inputs, [[0.0, -0.2, 0.0]])


@pytest.mark.parametrize("path_angle", [np.nan, np.inf, -1e300])
def test_a_level_flight_that_is_no_number_does_not_outlast_itself(controller, start, path_angle):
    controller._fly(0.0, start)
    vehicle = np.array([0.0, 0.0, 50.0, 1.0, path_angle, 4.0])
    held = controller._hold(0.05, vehicle, "no target position")
    assert np.all(np.isfinite(held.inputs))
    expected = np.exp(-0.1 / FADE_TIME) * held.inputs
    vehicle[4] = 0.0
    np.testing.assert_allclose(controller._hold(0.15, vehicle, "").inputs[0, 0], expected[0, 0])


def test_silence_is_reported_once(controller, start):
    controller._fly(0.0, start)
    words(controller)
    controller.fall_silent("vehicle state is lost")
    controller.fall_silent("vehicle state is lost")
    assert words(controller) == ["no command is sent, before optimal plan: vehicle state is lost"]


def test_the_direction_of_an_engagement_outlasts_a_loss_of_the_state():
    """Whoever took over is not flown the other way round, however the aircraft comes back."""
    parameters = load_configuration("small_uav", ["nmpc_controller.law=l1"]).controller
    controller = Controller(parameters)

    def answer(time, heading):
        velocity = 22.0 * np.array([math.cos(heading), math.sin(heading), 0.0])
        place = np.array([275.0, 0.0, 120.0]) + (time % 6.0) * velocity
        seen = Measurement(time, place, velocity, heading, 0.0, airspeed=22.0)
        command = controller.step(seen, time)
        with contextlib.suppress(MeasurementError):  # the state is doubted at first
            controller.see_target(time, np.zeros(3))
        return command

    times = 0.1 * np.arange(11)
    controller.engage(False)
    flown = [answer(time, 0.5 * math.pi) for time in times]
    assert flown[-1].orbit.direction == COUNTER_CLOCKWISE
    controller.engage(True)
    back = [answer(60.0 + time, -0.5 * math.pi) for time in times]
    assert {each.orbit.direction for each in back if each} == {COUNTER_CLOCKWISE}
    controller.engage(False)
    left = [answer(120.0 + time, -0.5 * math.pi) for time in times]
    assert left[-1].orbit.direction == CLOCKWISE


def test_plans_too_short_for_a_quarter_turn_are_warned_of():
    """A plan of an aircraft at 120 m/s that flies to the target must turn for 19 s."""
    jet = ["airspeed_max=180.0", "airspeed_min=80.0", "airspeed=120.0", "range=4000.0"]
    for step, warned in ((0.4, True), (1.0, False)):
        asked = (*jet, f"horizon_step={step}", "solver=ipopt")  # which need not be compiled
        asked = [f"nmpc_controller.{each}" for each in asked]
        told = words(Controller(load_configuration("small_uav", asked).controller))
        assert any("a quarter turn takes 19.2 s" in each for each in told) is warned


def test_states_older_than_is_counted_on_are_warned_of_once():
    controller = Controller(load_configuration("small_uav").controller)
    controller.see_target(0.0, np.zeros(3))
    told = []
    for k, late in enumerate([0.1, 0.6, 0.4, 0.7, 0.1, 0.8]):
        state = Measurement(0.05 * k, [300.0, k, 120.0], [0.0, 22.0, 0.0], 1.57, 0.0, airspeed=22.0)
        assert controller.step(state, 0.05 * k + late) is not None
        told += [late for each in words(controller) if "late, of which state_timeout" in each]
    assert told == [0.6, 0.8]


@pytest.mark.parametrize("engaged", [True, False])
def test_only_an_aircraft_that_flies_the_commands_is_too_slow(engaged):
    """On the ground, before somebody takes over, nothing is said of its engine."""
    controller = Controller(small_uav.parameters("law=l1"))
    controller.engage(engaged)
    for time in np.arange(0.0, 6.0, 0.05):
        controller.see_target(time, [300.0, 0.0, 0.0])
        at_rest = Measurement(time, np.zeros(3), np.zeros(3), 0.0, 0.0, airspeed=0.5)
        controller.step(at_rest, time)
    assert any("does the engine run" in each for each in words(controller)) == engaged
