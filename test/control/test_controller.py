from dataclasses import replace

import numpy as np
import pytest
import small_uav
from hypothesis import given, settings
from hypothesis import strategies as st

from uav_tracking_mpc.control.command_shaping import FADE_TIME
from uav_tracking_mpc.control.controller import Controller
from uav_tracking_mpc.control.event import Level
from uav_tracking_mpc.control.fallback import FallbackMode
from uav_tracking_mpc.control.guidance import formulation_of
from uav_tracking_mpc.dynamics.orbit import CLOCKWISE, COUNTER_CLOCKWISE
from uav_tracking_mpc.dynamics.relative import vehicle_state
from uav_tracking_mpc.estimation.forecast import Forecast, steady_forecast
from uav_tracking_mpc.estimation.measurement import Measurement
from uav_tracking_mpc.estimation.navigator import Estimate
from uav_tracking_mpc.estimation.situation import Situation
from uav_tracking_mpc.formulation.flight_formulation import FlightFormulation
from uav_tracking_mpc.formulation.formulation import Plan
from uav_tracking_mpc.formulation.paper_formulation import PaperFormulation
from uav_tracking_mpc.laws import GuidanceLaw
from uav_tracking_mpc.laws.vector_field import VectorField
from uav_tracking_mpc.mpc.solution import Solution, Status
from uav_tracking_mpc.parameters.registry import GUIDANCE_LAW
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
        self.change, self.decrease = formulation.change, None
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


def estimate(now, stages=PAPER.horizon):
    return Estimate(now, now, steady_forecast(now, stages))


def words(controller):
    """What has been reported since the last call."""
    return [event.words for event in controller.events.take()]


def paper_situation(relative):
    vehicle = vehicle_state(relative, 0.4, np.zeros(3))
    return Situation(vehicle, np.zeros(3), np.zeros(3), np.zeros(3), np.zeros(3))


@pytest.fixture(scope="module")
def paper_formulation():
    return PaperFormulation(PAPER)


@pytest.fixture
def controller(paper_formulation):
    paper_formulation.reset()
    return Controller(PAPER, Faulty(paper_formulation))


@pytest.fixture
def start(paper_start):
    return estimate(paper_situation(paper_start))


def flight_controller(parameters=FLIGHT):
    return Controller(parameters, FlightFormulation(parameters, small_uav.solver()))


def limits(parameters, airspeed):
    upper = parameters.input_upper
    upper[0] = parameters.envelope.turn_rate_max(airspeed)
    lower = parameters.input_lower
    lower[0] = -upper[0]
    return lower, upper


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
    later = controller._fly(2.1 + FADE_TIME, start)
    np.testing.assert_allclose(later.inputs, [law], atol=1e-12)


def test_after_a_failure_it_returns_to_optimal_plans(controller, start):
    controller._fly(0.0, start)
    controller.formulation.status = Status.FAILED
    assert controller._fly(5.0, start).mode is FallbackMode.LOITER
    controller.formulation.status = None
    command = controller._fly(5.1, start)
    assert (command.mode, command.reason) == (FallbackMode.OPTIMAL, "")
    assert words(controller)[-1] == "now flying optimal plan, before loiter law"


@pytest.mark.parametrize("error", [ValueError("no such value"), ZeroDivisionError("by zero")])
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
    expected = 0.8 * held.inputs  # what fades out, by a fifth of the time
    vehicle[4] = 0.0
    np.testing.assert_allclose(controller._hold(0.15, vehicle, "").inputs[0, 0], expected[0, 0])


def test_silence_is_reported_once(controller, start):
    controller._fly(0.0, start)
    words(controller)
    controller.fall_silent("vehicle state is lost")
    controller.fall_silent("vehicle state is lost")
    assert words(controller) == ["now flying silence, before optimal plan: vehicle state is lost"]


class Constant:
    """A formulation with one plan for everything, and a solver that is told when to fail."""

    solver = None
    step = 0.5

    def __init__(self, inputs):
        self.plan, self.converges = np.tile(inputs, (20, 1)), True

    def reset(self):
        pass

    def change(self, parameters):
        pass

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
@settings(max_examples=40, deadline=None)
@given(when=times, seen=st.lists(estimates(PAPER.horizon), min_size=3, max_size=3))
def test_whatever_comes_in_the_command_is_finite_and_inside_the_limits(
    paper_formulation, when, seen
):
    check_anything(Controller(PAPER, paper_formulation), when, seen)


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
@settings(max_examples=40, deadline=None)
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
        ("range", 160.0), ("airspeed", 5.0), ("direction", "counter_clockwise"),
        ("state_weights", (1.0,) * 5), ("yaw_rate_max", 0.5), ("terminal_scaling", 3.0),
    ],
)  # fmt: skip
def test_what_the_papers_problem_rests_on_is_fixed_in_flight(controller, start, name, value):
    with pytest.raises(ParameterError, match=f"'{name}' is .* must stay .* unless .*artificial"):
        controller.change(plan_age_max=9.0, **{name: value})
    assert controller.parameters is PAPER
    assert controller._fly(0.0, start).orbit == PAPER.orbit


def test_a_time_budget_set_in_flight_holds(controller):
    controller.change(solve_time_max=1.5, target_timeout=3.0)
    assert controller.formulation.solver.time_limit == 1.5
    controller.change(solve_time_max=PAPER.solve_time_max)


# From a measurement to a command.

TICK = 0.05
STILL = np.zeros(3)


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


def test_without_a_target_there_is_no_command_and_that_is_said_once(constant):
    assert [constant.step(measured(k * TICK), k * TICK) for k in range(5)] == [None] * 5
    assert constant.modes.reason == "no target position"
    assert constant.modes.counts[FallbackMode.SILENCE] == 5
    assert constant.events.take() == []  # it was silent before


def test_commands_keep_the_control_rate(constant):
    constant.see_target(0.0, STILL)
    answers = [constant.step(measured(k * TICK), k * TICK) for k in range(8)]
    assert [answer is not None for answer in answers] == [True, False] * 4
    assert answers[2].stamp == 2 * TICK
    np.testing.assert_array_equal(answers[0].inputs, constant.formulation.plan)


def test_a_target_that_was_never_lost_but_forgotten_leaves_the_wings_level(constant):
    constant.see_target(0.0, STILL)
    assert constant.step(measured(0.0), 0.0) is not None
    constant.navigator.target.reset()
    command = constant.step(measured(0.1, path_angle_rate=0.1), 0.1)
    assert (command.mode, command.reason) == (FallbackMode.HOLD, "no target position")


def test_a_target_of_another_clock_is_refused(constant):
    constant.see_target(0.0, STILL)
    constant.step(measured(0.0), 0.0)
    with pytest.raises(ValueError, match=r"3600.000 s ahead of the vehicle's, may be .*clocks"):
        constant.see_target(3600.0, STILL)
    with pytest.raises(ValueError, match="must be three finite numbers"):
        constant.see_target(0.1, [np.nan, 0.0, 0.0])


def test_an_old_target_is_circled_by_the_loiter_law(constant):
    constant.see_target(0.0, STILL)
    late = FLIGHT.target_timeout + 0.01
    command = constant.step(measured(late), late)
    assert (command.mode, command.reason) == (FallbackMode.LOITER, "target position is lost")
    constant.see_target(late, STILL)
    assert constant.step(measured(late + 0.1), late + 0.1).mode is FallbackMode.OPTIMAL


def test_an_outlier_is_not_answered_and_said_so(constant):
    constant.see_target(0.0, STILL)
    constant.step(measured(0.0), 0.0)
    assert constant.step(measured(0.1, (9e3, 0.0, 0.0)), 0.1) is None
    (event,) = [e for e in constant.events.take() if e.level is Level.REFUSAL]
    assert "jumped by" in event.words
    assert constant.state_time == 0.0
    assert constant.step(measured(0.1), 0.1) is not None


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
    assert "answered only after" in words(controller)[-1]


def test_without_air_data_the_air_is_taken_as_still_and_that_is_said_once(constant):
    constant.see_target(0.0, STILL)
    wind = np.array([5.0, 0.0, 0.0])
    for k in range(4):
        constant.step(measured(0.1 * k, wind=wind, airspeed=None), 0.1 * k)
    assert [w for w in words(constant) if "air" in w] == [
        "no airspeed is measured: the air is taken as still"
    ]
    np.testing.assert_allclose(constant.drift, 0.0, atol=1e-12)
    constant.see_air(0.4, 22.0)
    command = constant.step(measured(0.4, wind=wind, airspeed=None), 0.4)
    np.testing.assert_allclose(constant.drift, wind, atol=1e-12)
    assert command.present.airspeed == 22.0


@pytest.mark.parametrize("law", ["l1", "vector_field"])
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


def test_what_is_planned_is_flown_from_when_it_was_sent(constant):
    """A late answer: until then the aircraft flew what it had been told before."""
    constant.see_target(0.0, STILL)
    constant.step(measured(0.0), 0.0)
    constant.formulation.plan = constant.formulation.plan + np.array([0.0, 0.1, 0.0])
    constant.step(measured(0.1), 0.14)
    history = constant.navigator._history
    assert [history.demanded(time, 1) for time in (0.0, 0.13, 0.15)] == [0.0, 0.0, 0.1]
