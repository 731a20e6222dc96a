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

"""Between modes, at any input, and when parameters change: commands stay finite, inside, steady."""

from dataclasses import replace

import numpy as np
import pytest
import small_uav
from controller_cases import FLIGHT, PAPER, Constant, estimate, flight_controller, limits
from hypothesis import given
from hypothesis import strategies as st

from uav_tracking_mpc.control.command_shaping import FADE_TIME
from uav_tracking_mpc.control.controller import Controller
from uav_tracking_mpc.control.fallback import FallbackMode
from uav_tracking_mpc.dynamics.orbit import CLOCKWISE, COUNTER_CLOCKWISE
from uav_tracking_mpc.estimation.navigator import Estimate
from uav_tracking_mpc.estimation.situation import Forecast, Situation
from uav_tracking_mpc.formulation.flight_formulation import FlightFormulation
from uav_tracking_mpc.laws.vector_field import VectorField
from uav_tracking_mpc.parameters.specification import ParameterError
from uav_tracking_mpc.terminal import ingredients


@given(
    st.lists(st.sampled_from(["plan", "no plan", "no target", "silence"]), max_size=60),
    st.tuples(st.floats(-0.4, 0.4), st.floats(-0.5, 0.5), st.floats(-1.5, 3.0)),
)
def test_no_way_between_the_modes_lets_the_command_jump(walk, planned):
    """20 Hz, and nothing else changes: plan, law and level flight blend into each other."""
    formulation = Constant(planned)
    controller = Controller(replace(FLIGHT, plan_age_max=0.3, direction=CLOCKWISE), formulation)
    now = small_uav.situation(300.0, 100.0, 90.0, path_angle=0.1)
    level = np.array([0.0, -0.1, 0.0])
    law = VectorField(controller.orbit, FLIGHT.envelope).inputs(now)
    everything = np.array([planned, law, level])
    reach = np.ptp(everything, axis=0) * 0.05 / FADE_TIME + 1e-12
    before = None
    for k, event in enumerate(walk):
        formulation.converges = event == "plan"
        if event == "silence":
            controller.fall_silent("told to")
            before = None
            continue
        if event == "no target":
            inputs = controller._hold(0.05 * k, now.vehicle, "").inputs[0]
        else:
            inputs = controller._fly(0.05 * k, estimate(now, FLIGHT.horizon)).inputs[0]
        if before is not None:
            assert np.all(np.abs(inputs - before) <= reach)
        before = inputs


odd = st.floats() | st.sampled_from([np.nan, np.inf, -np.inf, 1e300, -1e300, 0.0])


def odd_estimate(stages, seed, places):
    """A flight somewhere, with a few values that are anything."""
    values = np.random.default_rng(seed).uniform(-30.0, 30.0, 27)
    for place, value in places:
        values[place] = value
    vehicle, *vectors = np.split(values, [6, 9, 12, 15, 18])
    ahead = [np.tile(row, (stages + 1, 1)) for row in vectors.pop().reshape(3, 3)]
    situation = Situation(vehicle, *vectors)
    return Estimate(situation, situation, Forecast(*ahead))


def estimates(stages):
    places = st.lists(st.tuples(st.integers(0, 26), odd), max_size=4)
    return st.builds(odd_estimate, st.just(stages), st.integers(0, 1000), places)


times = st.lists(st.sampled_from([0.0, 0.1, 0.3, 1e9, -5.0, 3.0]), min_size=3, max_size=3)


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
@given(when=times, seen=st.lists(estimates(PAPER.horizon), min_size=3, max_size=3))
def test_whatever_comes_in_the_command_is_finite_and_inside_the_limits(
    paper_formulation, when, seen
):
    check_anything(Controller(PAPER, paper_formulation), when, seen)


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
@given(when=times, seen=st.lists(estimates(FLIGHT.horizon), min_size=3, max_size=3))
def test_whatever_comes_in_a_flight_the_command_is_finite_and_inside_the_limits(when, seen):
    check_anything(flight_controller(replace(FLIGHT, solve_time_max=0.01)), when, seen)


def check_anything(controller, when, seen):
    controller.reset()
    for time, ahead in zip(when, seen, strict=True):
        for command in (
            controller._fly(time, ahead),
            controller._hold(time, ahead.effect.vehicle, ""),
        ):
            airspeed = ahead.effect.vehicle[5]
            lower, upper = limits(controller.parameters, airspeed if np.isfinite(airspeed) else 0.0)
            assert np.all(np.isfinite(command.inputs))
            assert np.all((command.inputs >= lower) & (command.inputs <= upper))


class Recorder:
    """A solver that tells whether it was asked for a cold start's guess."""

    def __init__(self, solver):
        self.solver, self.name, self.problem = solver, solver.name, solver.problem
        self.reset, self.guessed = solver.reset, False

    def solve(self, initial_state, parameters=None, elapsed=None, guess=None):
        self.guessed = False

        def noted():
            self.guessed = True
            return guess()

        return self.solver.solve(initial_state, parameters, elapsed, noted)


def test_orbit_weights_and_limits_change_in_flight_and_the_plan_goes_on():
    """No other problem is compiled, and the last plan is the next one's start."""
    recorder = Recorder(small_uav.solver())
    controller = Controller(FLIGHT, FlightFormulation(FLIGHT, recorder))
    now = estimate(small_uav.on_orbit(FLIGHT, 0.0, -1.0), FLIGHT.horizon)
    before = controller._fly(0.0, now)
    assert recorder.guessed
    controller.change(
        range=330.0, airspeed=24.0, bank_max=0.6, state_weights=(0.04, 0.1, 0.1, 0.3, 0.5)
    )
    after = controller._fly(0.05, now)
    assert after.mode is FallbackMode.OPTIMAL
    assert not recorder.guessed
    assert controller.formulation.solver is recorder
    assert (after.orbit.range, after.orbit.speed) == (330.0, 24.0)
    np.testing.assert_allclose(after.inputs[0], before.inputs[0], atol=1e-6)  # without a jump
    after = controller._fly(0.6, now)
    assert after.inputs[0, 2] > before.inputs[0, 2] + 0.1  # faster
    assert after.inputs[0, 0] > before.inputs[0, 0] + 0.1  # outwards, to the left of a right turn
    controller.change(acceleration_max=0.05)
    assert controller._fly(0.7, now).inputs[:, 2].max() <= 0.05


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_the_direction_that_was_nearest_outlasts_a_change(sense):
    controller = flight_controller()
    now = estimate(small_uav.on_orbit(FLIGHT, 0.0, sense), FLIGHT.horizon)
    chosen = controller._fly(0.0, now).orbit.direction
    controller.change(range=310.0)
    command = controller._fly(0.05, now)
    assert (command.orbit.range, command.orbit.direction) == (310.0, chosen)
    controller.change(direction=COUNTER_CLOCKWISE)
    assert controller._fly(0.1, now).orbit.direction == COUNTER_CLOCKWISE


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("horizon", 25), ("horizon_step", 0.3), ("solver", "ipopt"), ("limit_penalty", 10.0),
        ("scheme", "rk4"), ("certificate", "file"), ("law", "l1"), ("record", "file"),
    ],
)  # fmt: skip
def test_what_is_fixed_cannot_change_and_then_nothing_does(name, value):
    controller = Controller(FLIGHT, Constant(np.zeros(3)))
    with pytest.raises(ParameterError, match=f"'{name}' is .* must stay"):
        controller.change(range=310.0, **{name: value})
    assert controller.parameters is FLIGHT
    assert controller.orbit == FLIGHT.orbit


@pytest.mark.parametrize(
    ("values", "told"),
    [
        ({"range": 125.0}, "the nearest orbit that can be flown has a range of"),
        ({"rnage": 310.0}, "'rnage' is unknown"),
        ({"range": 310.0, "altitude": float("nan")}, "'altitude' is nan"),
    ],
)
def test_a_change_that_cannot_be_flown_is_refused_in_words(values, told):
    controller = Controller(FLIGHT, Constant(np.zeros(3)))
    with pytest.raises(ParameterError, match=told):
        controller.change(**values)
    assert controller.parameters is FLIGHT


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("state_weights", (1.0,) * 5), ("yaw_rate_max", 0.5), ("terminal_scaling", 3.0),
    ],
)  # fmt: skip
def test_what_the_papers_problem_rests_on_is_fixed_in_flight(controller, start, name, value):
    with pytest.raises(ParameterError, match=f"'{name}' is .* must stay .* unless .*artificial"):
        controller.change(plan_age_max=9.0, **{name: value})
    assert controller.parameters is PAPER
    assert controller._fly(0.0, start).orbit == PAPER.orbit


def test_a_law_takes_other_limits_in_flight():
    controller = Controller(replace(PAPER, law="vector_field"))
    controller.change(yaw_rate_max=0.5)
    assert controller.parameters.envelope.yaw_rate_max == 0.5


def test_the_papers_problem_takes_a_new_orbit(controller, start):
    try:
        controller.change(range=160.0, direction=COUNTER_CLOCKWISE)
        command = controller._fly(0.0, start)
        assert command.mode is FallbackMode.OPTIMAL
        assert (command.orbit.range, command.orbit.direction) == (160.0, COUNTER_CLOCKWISE)
    finally:
        controller.change(range=PAPER.range, direction=PAPER.direction)


def test_an_orbit_that_the_papers_problem_cannot_hold_is_refused(controller, monkeypatch):
    def unsolvable(*_):
        raise np.linalg.LinAlgError("the pencil has eigenvalues on the unit circle")

    monkeypatch.setattr(ingredients, "solve_discrete_are", unsolvable)
    before = controller.formulation.solver.problem
    with pytest.raises(ParameterError, match="unit circle"):
        controller.change(range=171.0, plan_age_max=9.0)
    assert controller.parameters.plan_age_max == PAPER.plan_age_max
    assert controller.formulation.solver.problem is before


def test_a_time_budget_set_in_flight_holds(controller):
    controller.change(solve_time_max=1.5, target_timeout=3.0)
    assert controller.formulation.solver.time_limit == 1.5
    controller.change(solve_time_max=PAPER.solve_time_max)
