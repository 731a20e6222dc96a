from dataclasses import replace

import numpy as np
import pytest
import small_uav
from hypothesis import given, settings
from hypothesis import strategies as st
from uav_tracking_mpc.control.pilot import BLEND_TIME, Outlook, Pilot, formulation_of

from uav_tracking_mpc.control.fallback import Rung
from uav_tracking_mpc.dynamics.orbit import CLOCKWISE, COUNTER_CLOCKWISE
from uav_tracking_mpc.dynamics.relative import vehicle_state
from uav_tracking_mpc.estimation.forecast import Forecast, steady_forecast
from uav_tracking_mpc.estimation.situation import Situation
from uav_tracking_mpc.formulation.flight_formulation import FlightFormulation
from uav_tracking_mpc.formulation.formulation import Plan
from uav_tracking_mpc.formulation.paper_formulation import PaperFormulation
from uav_tracking_mpc.laws.vector_field import VectorField
from uav_tracking_mpc.mpc.solution import Solution, Status
from uav_tracking_mpc.parameters.specification import ParameterError
from uav_tracking_mpc.settings.tracking import TrackingParameters

PAPER = TrackingParameters()
FLIGHT = small_uav.parameters()


class Faulty:
    """A formulation whose plans are passed on until it is told otherwise.

    Attributes:
        status: What the solver is made to say; None for the truth.
        violation: Of hard constraints, with that status.
        error: Raised in the place of an answer.
    """

    def __init__(self, formulation):
        self.formulation = formulation
        self.solver, self.step, self.reset = formulation.solver, formulation.step, formulation.reset
        self.change, self.check = formulation.change, formulation.check
        self.status = self.error = None
        self.violation = 0.0

    def solve(self, situation, forecast, orbit, elapsed):
        if self.error is not None:
            raise self.error
        plan = self.formulation.solve(situation, forecast, orbit, elapsed)
        if self.status is None:
            return plan
        changes = {"status": self.status, "message": "told to", "violation": self.violation}
        return replace(plan, solution=replace(plan.solution, **changes))


def outlook(now, stages=PAPER.horizon, fresh=True):
    return Outlook(now, steady_forecast(now, stages), fresh)


def paper_situation(relative):
    vehicle = vehicle_state(relative, 0.4, np.zeros(3))
    return Situation(vehicle, np.zeros(3), np.zeros(3), np.zeros(3), np.zeros(3))


@pytest.fixture(scope="module")
def paper_formulation():
    return PaperFormulation(PAPER)


@pytest.fixture
def pilot(paper_formulation):
    paper_formulation.reset()
    return Pilot(PAPER, Faulty(paper_formulation))


@pytest.fixture
def start(paper_start):
    return outlook(paper_situation(paper_start))


def flight_pilot(parameters=FLIGHT):
    return Pilot(parameters, FlightFormulation(parameters, small_uav.solver()))


def limits(parameters, airspeed):
    upper = parameters.input_upper
    upper[0] = parameters.envelope.turn_rate_max(airspeed)
    lower = parameters.input_lower
    lower[0] = -upper[0]
    return lower, upper


def test_the_parameters_choose_the_formulation():
    assert isinstance(formulation_of(PAPER), PaperFormulation)
    assert isinstance(formulation_of(FLIGHT), FlightFormulation)


def test_on_the_orbit_the_steady_turn_is_commanded(pilot):
    command = pilot.step(0.0, outlook(paper_situation(PAPER.orbit.steady_state)))
    assert (command.rung, command.reason) == (Rung.OPTIMAL, "")
    np.testing.assert_allclose(command.inputs[0], PAPER.steady_inputs, atol=1e-6)


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_on_the_orbit_the_steady_turn_is_commanded_in_a_flight(sense):
    pilot = flight_pilot()
    command = pilot.step(0.0, outlook(small_uav.on_orbit(FLIGHT, 2.0, sense), FLIGHT.horizon))
    assert command.rung is Rung.OPTIMAL
    assert command.orbit.direction == (COUNTER_CLOCKWISE if sense > 0.0 else CLOCKWISE)
    steady = [sense * FLIGHT.orbit.speed / FLIGHT.orbit.radius, 0.0, 0.0]
    np.testing.assert_allclose(command.inputs, np.tile(steady, (FLIGHT.horizon, 1)), atol=1e-4)


def test_command_is_the_first_of_the_plan(pilot, start):
    command = pilot.step(0.0, start)
    np.testing.assert_allclose(command.inputs[0], [0.6754, 0.7854, 1.0], atol=6e-5)
    assert command.inputs.shape == (PAPER.horizon, 3)
    assert command.step == PAPER.horizon_step
    assert command.solution is command.plan.solution


def test_a_failed_solve_is_bridged_by_the_earlier_plan(pilot, start):
    plan = pilot.step(10.0, start).inputs
    pilot.formulation.status = Status.FAILED
    bridged = pilot.step(11.5, start)
    assert (bridged.rung, bridged.reason) == (Rung.EARLIER_PLAN, "told to")
    assert str(bridged.change) == "now flying earlier plan, before optimal plan: told to"
    np.testing.assert_array_equal(bridged.inputs, plan[1:])  # 1.5 s later the second stage runs


def test_an_earlier_plan_is_not_flown_for_ever(pilot, start):
    """Then the loiter law takes over, without a jump."""
    law = VectorField(PAPER.orbit, PAPER.envelope).inputs(start.situation)
    pilot.step(0.0, start)
    pilot.formulation.status = Status.FAILED
    bridged = pilot.step(2.0, start)
    assert bridged.rung is Rung.EARLIER_PLAN
    late = pilot.step(2.1, start)
    assert (late.rung, late.reason) == (Rung.LOITER, "told to")
    np.testing.assert_allclose(late.inputs[0], bridged.inputs[0], atol=1e-12)
    later = pilot.step(2.1 + BLEND_TIME, start)
    np.testing.assert_allclose(later.inputs, [law], atol=1e-12)


def test_after_a_failure_it_returns_to_optimal_plans(pilot, start):
    pilot.step(0.0, start)
    pilot.formulation.status = Status.FAILED
    assert pilot.step(5.0, start).rung is Rung.LOITER
    pilot.formulation.status = None
    command = pilot.step(5.1, start)
    assert (command.rung, command.reason) == (Rung.OPTIMAL, "")
    assert str(command.change) == "now flying optimal plans, before loiter law"


@pytest.mark.parametrize("error", [ValueError("no such value"), ZeroDivisionError("by zero")])
def test_a_controller_that_breaks_is_survived_and_named(pilot, start, error):
    pilot.step(0.0, start)
    pilot.formulation.error = error
    command = pilot.step(0.1, start)
    assert command.rung is Rung.EARLIER_PLAN
    assert command.reason == f"the controller failed: {error}"
    assert command.solution is None


@pytest.mark.parametrize("status", [Status.TIME_LIMIT, Status.ITERATION_LIMIT])
def test_an_unfinished_plan_is_flown_if_it_is_feasible(pilot, start, status):
    pilot.formulation.status = status
    command = pilot.step(0.0, start)
    assert (command.rung, command.reason) == (Rung.FEASIBLE, "told to")
    np.testing.assert_array_equal(command.inputs, command.plan.inputs)
    pilot.formulation.violation = 0.1
    assert pilot.step(0.1, start).rung is Rung.EARLIER_PLAN  # the feasible one
    pilot.reset()
    assert pilot.step(0.2, start).rung is Rung.LOITER


def test_a_budget_that_is_too_short_still_gives_a_command():
    formulation = FlightFormulation(replace(FLIGHT, solve_time_max=1e-4), small_uav.solver())
    pilot = Pilot(formulation.parameters, formulation)
    now = small_uav.situation(drift=(6.0, -3.0, 0.0))
    command = pilot.step(0.0, outlook(now, FLIGHT.horizon))
    assert command.solution.status is Status.TIME_LIMIT
    assert command.rung in (Rung.FEASIBLE, Rung.LOITER)
    lower, upper = limits(FLIGHT, 22.0)
    assert np.all((lower <= command.inputs) & (command.inputs <= upper))


def test_without_a_fresh_target_the_law_flies(pilot, start):
    command = pilot.step(0.0, replace(start, target_fresh=False))
    assert (command.rung, command.reason) == (Rung.LOITER, "target position is lost")
    assert command.plan is None


def test_reset_forgets_the_plan(pilot, start):
    pilot.step(0.0, start)
    pilot.reset()
    pilot.formulation.status = Status.FAILED
    assert pilot.step(0.1, start).rung is Rung.LOITER


def test_without_a_target_it_levels_out(pilot):
    vehicle = np.array([0.0, 0.0, 50.0, 1.0, 0.2, 4.0])
    command = pilot.hold(0.0, vehicle, "no target position yet")
    assert (command.rung, command.reason) == (Rung.HOLD, "no target position yet")
    np.testing.assert_allclose(command.inputs, [[0.0, -0.2, 0.0]])


@pytest.mark.parametrize("path_angle", [np.nan, np.inf, -1e300])
def test_a_level_flight_that_is_no_number_does_not_outlast_itself(pilot, start, path_angle):
    pilot.step(0.0, start)
    vehicle = np.array([0.0, 0.0, 50.0, 1.0, path_angle, 4.0])
    held = pilot.hold(0.05, vehicle, "no target position")
    assert np.all(np.isfinite(held.inputs))
    expected = 0.8 * held.inputs  # what fades out, by a fifth of the time
    vehicle[4] = 0.0
    np.testing.assert_allclose(pilot.hold(0.15, vehicle, "").inputs[0, 0], expected[0, 0])


def test_silence_is_news_once(pilot, start):
    pilot.step(0.0, start)
    assert str(pilot.fall_silent("")) == (
        "now flying silence, before optimal plan: vehicle state is lost"
    )
    assert pilot.fall_silent("") is None


class Constant:
    """A formulation with one plan for everything, and a solver that is told when to fail."""

    solver = None
    step = 0.5

    def __init__(self, inputs):
        self.plan, self.converges = np.tile(inputs, (20, 1)), True

    def reset(self):
        pass

    def check(self, parameters):
        """Takes everything."""

    def solve(self, situation, forecast, orbit, elapsed):
        status = Status.CONVERGED if self.converges else Status.FAILED
        nothing = np.zeros((0, 3))
        solution = Solution(status, "as told", 1.0, 1, 0.0, nothing, nothing, np.zeros(3), 0.0)
        return Plan(self.plan, self.step, np.zeros(5), solution)


@settings(max_examples=50, deadline=None)
@given(
    st.lists(st.sampled_from(["plan", "no plan", "no target", "silence"]), max_size=60),
    st.tuples(st.floats(-0.4, 0.4), st.floats(-0.5, 0.5), st.floats(-1.5, 3.0)),
)
def test_no_way_over_the_ladder_lets_the_command_jump(walk, planned):
    """20 Hz, and nothing else changes: plan, law and level flight blend into each other."""
    formulation = Constant(planned)
    pilot = Pilot(replace(FLIGHT, plan_age_max=0.3, direction=CLOCKWISE), formulation)
    now = small_uav.situation(300.0, 100.0, 90.0, path_angle=0.1)
    level = np.array([0.0, -0.1, 0.0])
    law = VectorField(pilot.orbit, pilot.envelope).inputs(now)
    everything = np.array([planned, law, level])
    reach = np.ptp(everything, axis=0) * 0.05 / BLEND_TIME + 1e-12
    before = None
    for k, event in enumerate(walk):
        formulation.converges = event == "plan"
        if event == "silence":
            pilot.fall_silent("")
            before = None
            continue
        if event == "no target":
            inputs = pilot.hold(0.05 * k, now.vehicle, "").inputs[0]
        else:
            inputs = pilot.step(0.05 * k, outlook(now, FLIGHT.horizon)).inputs[0]
        if before is not None:
            assert np.all(np.abs(inputs - before) <= reach)
        before = inputs


odd = st.floats() | st.sampled_from([np.nan, np.inf, -np.inf, 1e300, -1e300, 0.0])


def odd_outlook(stages, seed, places):
    """A flight somewhere, with a few values that are anything."""
    values = np.random.default_rng(seed).uniform(-30.0, 30.0, 27)
    for place, value in places:
        values[place] = value
    vehicle, *vectors = np.split(values, [6, 9, 12, 15, 18])
    ahead = [np.tile(row, (stages + 1, 1)) for row in vectors.pop().reshape(3, 3)]
    return Outlook(Situation(vehicle, *vectors), Forecast(*ahead))


def outlooks(stages):
    places = st.lists(st.tuples(st.integers(0, 26), odd), max_size=4)
    return st.builds(odd_outlook, st.just(stages), st.integers(0, 1000), places)


times = st.lists(st.sampled_from([0.0, 0.1, 0.3, 1e9, -5.0, 3.0]), min_size=3, max_size=3)


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
@settings(max_examples=40, deadline=None)
@given(when=times, seen=st.lists(outlooks(PAPER.horizon), min_size=3, max_size=3))
def test_whatever_comes_in_the_command_is_finite_and_inside_the_limits(
    paper_formulation, when, seen
):
    check_anything(Pilot(PAPER, paper_formulation), when, seen)


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
@settings(max_examples=40, deadline=None)
@given(when=times, seen=st.lists(outlooks(FLIGHT.horizon), min_size=3, max_size=3))
def test_whatever_comes_in_a_flight_the_command_is_finite_and_inside_the_limits(when, seen):
    check_anything(flight_pilot(replace(FLIGHT, solve_time_max=0.01)), when, seen)


def check_anything(pilot, when, seen):
    pilot.reset()
    for time, ahead in zip(when, seen, strict=True):
        for command in (
            pilot.step(time, ahead),
            pilot.hold(time, ahead.situation.vehicle, ""),
        ):
            airspeed = ahead.situation.vehicle[5]
            lower, upper = limits(pilot.parameters, airspeed if np.isfinite(airspeed) else 0.0)
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
    pilot = Pilot(FLIGHT, FlightFormulation(FLIGHT, recorder))
    now = outlook(small_uav.on_orbit(FLIGHT, 0.0, -1.0), FLIGHT.horizon)
    before = pilot.step(0.0, now)
    assert recorder.guessed
    wider = replace(
        FLIGHT, range=330.0, airspeed=24.0, bank_max=0.6, state_weights=(0.04, 0.1, 0.1, 0.3, 0.5)
    )
    pilot.change(wider)
    after = pilot.step(0.05, now)
    assert after.rung is Rung.OPTIMAL
    assert not recorder.guessed
    assert pilot.formulation.solver is recorder
    assert (after.orbit.range, after.orbit.speed) == (330.0, 24.0)
    np.testing.assert_allclose(after.inputs[0], before.inputs[0], atol=1e-6)  # without a jump
    after = pilot.step(0.6, now)
    assert after.inputs[0, 2] > before.inputs[0, 2] + 0.1  # faster
    assert after.inputs[0, 0] > before.inputs[0, 0] + 0.1  # outwards, to the left of a right turn
    tight = replace(wider, acceleration_max=0.05)
    pilot.change(tight)
    assert pilot.step(0.7, now).inputs[:, 2].max() <= 0.05


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_the_direction_that_was_nearest_outlasts_a_change(sense):
    pilot = flight_pilot()
    now = outlook(small_uav.on_orbit(FLIGHT, 0.0, sense), FLIGHT.horizon)
    chosen = pilot.step(0.0, now).orbit.direction
    pilot.change(replace(FLIGHT, range=310.0))
    command = pilot.step(0.05, now)
    assert (command.orbit.range, command.orbit.direction) == (310.0, chosen)
    pilot.change(replace(FLIGHT, direction=COUNTER_CLOCKWISE))
    assert pilot.step(0.1, now).orbit.direction == COUNTER_CLOCKWISE


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("horizon", 25), ("horizon_step", 0.3), ("rate_lag", (0.3, 0.2, 0.2)),
        ("dead_time", (0.0, 0.0, 0.0)), ("solver", "ipopt"), ("limit_penalty", 10.0),
        ("scheme", "rk4"), ("certificate", "file"),
    ],
)  # fmt: skip
def test_what_is_compiled_cannot_change_and_then_nothing_does(name, value):
    pilot = Pilot(FLIGHT, Constant(np.zeros(3)))
    with pytest.raises(ParameterError, match=f"'{name}' is .* must stay"):
        pilot.change(replace(FLIGHT, range=310.0, **{name: value}))
    assert pilot.parameters is FLIGHT
    assert pilot.orbit == FLIGHT.orbit


def test_a_refusal_of_the_formulation_leaves_everything_as_it_was(pilot, start):
    with pytest.raises(ParameterError, match="'range' is 160.0, must stay 150.0 in flight"):
        pilot.change(replace(PAPER, range=160.0, plan_age_max=9.0))
    assert pilot.parameters is PAPER
    assert pilot.step(0.0, start).orbit == PAPER.orbit
