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

"""The flight problem: the paper's where nothing drifts, lags or limits; solved as by IPOPT."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import casadi as ca
import numpy as np
import pytest
import small_uav
from solver_problems import kkt_residual

from uav_tracking_mpc.dynamics.orbit import DIRECTIONS
from uav_tracking_mpc.dynamics.relative import (
    error_dynamics,
    relative_state,
    steady_inputs,
    tracking_error,
    vehicle_state,
)
from uav_tracking_mpc.dynamics.vehicle_models import Drift, VehicleState
from uav_tracking_mpc.estimation.situation import steady_forecast
from uav_tracking_mpc.formulation.flight_formulation import FlightFormulation, flight_problem
from uav_tracking_mpc.formulation.flight_problem import DECISION_SCALE, SMALL
from uav_tracking_mpc.formulation.paper_formulation import problem_of
from uav_tracking_mpc.mpc.casadi_solver import CasadiSolver
from uav_tracking_mpc.mpc.solver import Guess

FLIGHT = small_uav.parameters()
N = FLIGHT.horizon
# No limit is near, nothing lags, and the horizon is long: the paper's world.
STILL = small_uav.parameters(
    "rate_lag=[0, 0, 0]",
    "dead_time=[0, 0, 0]",
    "rate_weights=[0, 0, 0]",
    "bank_max=1.5",
    "roll_rate_max=50",
    "airspeed_band=10",
    "direction=counter_clockwise",
    "scheme=rk4",
)


LAGGED = small_uav.flight()


def data_of(parameters, orbit, drift=(0.0, 0.0, 0.0)):
    """The parameter p of a stage about a target at the origin."""
    formulation = FlightFormulation(parameters, NO_SOLVER)
    still = small_uav.situation(drift=drift)
    return formulation.data(steady_forecast(still, parameters.horizon), orbit)[0].copy()


NO_SOLVER: Any = SimpleNamespace()  # for a formulation that only states its problem


def decision_of(orbit):
    return np.array([orbit.radius, orbit.altitude, orbit.speed]) / DECISION_SCALE


def state_of(vehicle, rates=(0.0, 0.0, 0.0)):
    """State of a vehicle about a target at the origin."""
    return VehicleState(*vehicle, *rates)


def shares_of(inputs, state, data, flight=LAGGED):
    """Shares that give inputs (u_psi, u_chi, u_v) in a state."""
    middle, half = (np.array(part) for part in flight.span(state, data))
    return (inputs - middle) / half


def stage_function(problem):
    return ca.Function(
        "stage",
        [problem.state, problem.inputs, problem.parameter, problem.decision],
        [problem.next_state, problem.stage_cost],
    )


@pytest.mark.parametrize("direction", DIRECTIONS)
def test_without_drift_the_stage_cost_is_that_of_the_paper(direction):
    """(14) at random states and inputs, on the wanted orbit; to rounding."""
    parameters = replace(
        STILL, direction=direction, force_min=(-60.0, -60.0), force_max=(60.0,) * 2
    )
    orbit, rng = parameters.orbit, np.random.default_rng(1)
    stage, data = stage_function(LAGGED.problem), data_of(parameters, orbit)
    q, r = np.diag(parameters.state_weights), np.diag(parameters.input_weights)
    for _ in range(50):
        relative = rng.uniform([150.0, -3.1, -140.0, -1.4, 14.0], [900.0, 3.1, 140.0, 1.4, 32.0])
        inputs = rng.uniform(parameters.input_lower, parameters.input_upper)
        vehicle = vehicle_state(relative, rng.uniform(-np.pi, np.pi), np.zeros(3))
        state = state_of(vehicle, inputs)  # nothing rolls
        cost = stage(state, shares_of(inputs, state, data), data, decision_of(orbit))[1]
        # Distances are smooth where they vanish: 1 cm is added to each, in squares.
        relative[0] = np.hypot(relative[0], SMALL)
        x = tracking_error(relative, orbit)
        u = inputs - steady_inputs("exact", orbit)
        assert float(cost) == pytest.approx(x @ q @ x + u @ r @ u, rel=1e-11)


def test_the_cost_of_changes_is_that_beyond_the_orbits_own():
    """Weighted squares of each rate's change over a step, less the orbit's change of turn."""
    weights = np.array([0.3, 5.0, 0.7])
    lag = {"rate_lag": (0.3, 0.13, 0.16)}
    orbit, rng = STILL.orbit, np.random.default_rng(5)
    told = [replace(STILL, **lag, rate_weights=w) for w in ((0.0,) * 3, tuple(weights))]
    drift, stage = (4.0, 2.0, 0.0), stage_function(LAGGED.problem)
    free, paid = (data_of(each, orbit, drift) for each in told)
    for _ in range(20):
        rates = rng.uniform([-0.2, -0.1, -0.5], [0.2, 0.1, 0.5])
        state = state_of([*rng.uniform(100.0, 300.0, 3), *rng.uniform(-0.3, 0.3, 2), 22.0], rates)
        shares, decision = rng.uniform(-0.5, 0.5, 3), decision_of(orbit)
        following, with_changes = stage(state, shares, paid, decision)
        _, without = stage(state, shares, free, decision)
        change = (np.array(following).ravel()[6:9] - rates) / STILL.horizon_step
        change[0] -= float(LAGGED.turn_acceleration(state, paid, decision))
        assert float(with_changes - without) == pytest.approx(weights @ change**2, rel=1e-9)


@pytest.mark.parametrize(("step", "error"), [(0.5, 3e-5), (0.25, 1e-6), (0.125, 3.5e-8)])
def test_a_step_is_the_papers_up_to_the_error_of_integration(step, error):
    """Against Runge-Kutta in the paper's coordinates: both are of fourth order."""
    parameters = replace(STILL, force_min=(-60.0, -60.0), force_max=(60.0, 60.0), horizon_step=step)
    flight = flight_problem(replace(parameters, horizon=1))
    stage = stage_function(flight.problem)
    orbit, rng = parameters.orbit, np.random.default_rng(3)
    dynamics = error_dynamics("exact", orbit, step, "rk4")
    data = data_of(parameters, orbit)
    worst = 0.0
    for _ in range(30):
        relative = rng.uniform([150.0, -3.1, -100.0, -0.3, 14.0], [900.0, 3.1, 140.0, 0.3, 32.0])
        inputs = rng.uniform([-0.4, -0.3, -2.0], [0.4, 0.3, 2.0])
        vehicle = vehicle_state(relative, 0.7, np.zeros(3))
        state = state_of(vehicle, inputs)
        shares = shares_of(inputs, state, data, flight)
        flown = stage(state, shares, data, decision_of(orbit))[0]
        x = tracking_error(relative_state(np.array(flown).ravel()[:6], np.zeros(3)), orbit)
        u = inputs - steady_inputs("exact", orbit)
        expected = np.array(dynamics(tracking_error(relative, orbit), u)).ravel()
        difference = x - expected
        difference[1] = np.arctan2(np.sin(difference[1]), np.cos(difference[1]))
        worst = max(worst, np.abs(difference).max())
    assert worst < error


@pytest.mark.parametrize("drift", [(0.0, 0.0, 0.0), (9.0, -6.0, 0.5)])
def test_a_flight_on_the_orbit_costs_nothing_in_any_drift(drift):
    """At its turn rate, fed forward by half a step, there is no error to be paid for."""
    orbit, parameters = STILL.orbit, STILL
    stage = stage_function(LAGGED.problem)
    data, drift = data_of(parameters, orbit, drift), np.array(drift)
    path_angle = -np.arcsin(drift[2] / orbit.speed)

    def motion(azimuth):
        """Air velocity, turn rate and rate of the azimuth: the module of the drifting orbit."""
        tangent = np.array([-np.sin(azimuth), np.cos(azimuth)])
        along = drift[:2] @ tangent
        root = np.sqrt(orbit.speed**2 - drift @ drift + along**2)
        speed = along + root
        air = speed * tangent - drift[:2]
        return air, speed**2 / (orbit.radius * root), speed / orbit.radius

    for azimuth in np.linspace(-3.0, 3.0, 7):
        air, turn, azimuth_rate = motion(azimuth)
        ahead = 0.5 * STILL.horizon_step * azimuth_rate * 1e-3
        lead = (motion(azimuth + ahead)[1] - motion(azimuth - ahead)[1]) / 2e-3
        state = state_of(
            [
                orbit.radius * np.cos(azimuth),
                orbit.radius * np.sin(azimuth),
                orbit.altitude,
                np.arctan2(air[1], air[0]),
                path_angle,
                orbit.speed,
            ]
        )
        shares = shares_of((turn + lead, 0.0, 0.0), state, data)
        assert float(stage(state, shares, data, decision_of(orbit))[1]) < 1e-12


def test_near_the_orbit_its_inputs_are_those_of_the_paper():
    """Same horizon, Runge-Kutta and Simpson; no lag, no drift, no limit near.

    The problems differ only in how they end: the paper's in the weight P_rho, this one on the
    orbit, which its weights hold to the wanted one. Over 10 s both are so near to the optimum of an
    infinite horizon that 2e-5 is left, of first inputs of 0.1.
    """
    weights = {"state_weights": (0.05, 1.0, 0.3, 0.5, 0.5), "input_weights": (0.04, 0.04, 0.2)}
    parameters = replace(
        STILL,
        **weights,
        offset_weights=(1e4, 1e4, 1e4),
        terminal_constraint="none",
        response_estimation=False,
    )
    paper = CasadiSolver(problem_of(parameters))
    flight = FlightFormulation(
        replace(parameters, terminal_constraint="artificial_orbit"), small_uav.solver()
    )
    orbit, rng = parameters.orbit, np.random.default_rng(4)
    for _ in range(5):
        size = np.array([0.4, 0.006, 0.2, 0.002, 0.05])
        relative = orbit.steady_state + rng.uniform(-size, size)
        vehicle = vehicle_state(relative, rng.uniform(-np.pi, np.pi), np.zeros(3))
        now = small_uav.situation(*vehicle)
        plan = flight.solve(now, steady_forecast(now, parameters.horizon), orbit, None)
        expected = paper.solve(tracking_error(relative, orbit)).inputs + parameters.steady_inputs
        assert plan.solution.converged
        assert np.abs(expected[0] - parameters.steady_inputs).max() > 0.01
        np.testing.assert_allclose(plan.inputs[:4], expected[:4], atol=5e-5)


@pytest.fixture(scope="module")
def plans():
    """Answers from 20 flyable situations: (situation, x_0, p, plan)."""
    formulation = FlightFormulation(FLIGHT, small_uav.shared_solver())
    answers = []
    for k, now in enumerate(small_uav.random_situations(20, seed=5)):
        orbit, ahead = replace(FLIGHT.orbit, direction=DIRECTIONS[k % 2]), steady_forecast(now, N)
        plan = formulation.solve(now, ahead, orbit, None)
        x_0, p = formulation.initial_state(now), formulation.data(ahead, orbit)
        answers.append((now, x_0, p.copy(), plan))
    return answers


def test_there_is_a_plan_from_wherever_the_aircraft_can_turn(plans):
    for now, _, _, plan in plans:
        assert plan.solution.converged, (now, plan.solution.message)
        assert plan.solution.violation < 1e-5


def test_every_input_of_every_plan_can_be_flown(plans):
    """Bank, yaw, pitch, acceleration and specific force, in the state in which it is flown."""
    envelope, slack = FLIGHT.envelope, 1e-9
    states = np.concatenate([plan.solution.states[:-1] for *_, plan in plans])
    turn, climb, gain = np.concatenate([plan.inputs for *_, plan in plans]).T
    _, _, _, _, path_angle, airspeed, *_ = states.T
    share = (airspeed - 14.0) / 18.0
    lower, upper = (
        slow + share * (fast - slow) for slow, fast in (envelope.force_min, envelope.force_max)
    )
    force = 9.80665 * np.sin(path_angle) + gain
    assert np.arctan(airspeed * abs(turn) / 9.80665).max() <= envelope.bank_max + slack
    assert abs(turn).max() <= envelope.yaw_rate_max + slack
    assert abs(climb).max() <= envelope.pitch_rate_max + slack
    assert envelope.acceleration_min - slack <= gain.min()
    assert gain.max() <= envelope.acceleration_max + slack
    assert np.all((lower - slack <= force) & (force <= upper + slack))


def test_every_plan_ends_on_an_orbit_that_can_be_flown(plans):
    """At its radius and height, along it in the drift, turning as it does."""
    for now, _, p, plan in plans:
        radius, altitude, speed = plan.solution.decision * DECISION_SCALE
        x, y, z, psi, chi, v, *rates = plan.solution.states[-1]
        sense = float(p[0][LAGGED.where["sense"]][0])
        assert np.hypot(np.hypot(x, y), z) == pytest.approx(np.hypot(radius, altitude), abs=1e-3)
        assert (z, v) == pytest.approx((altitude, speed), abs=1e-3)
        relative = v * np.cos(chi) * np.array([np.cos(psi), np.sin(psi)]) + now.drift[:2]
        tangent = sense * np.array([-y, x]) / np.hypot(x, y)
        assert relative / np.hypot(*relative) == pytest.approx(tangent, abs=1e-4)
        strength = np.hypot(*now.drift[:2])
        sharpest = (speed + strength) ** 2 / (radius * speed)
        assert sharpest <= 0.95 * FLIGHT.envelope.turn_rate_max(speed) + 1e-4
        assert abs(rates[0]) <= sharpest + 1e-4 and np.abs(rates[1:]).max() < 1e-4


def test_the_answers_satisfy_the_optimality_conditions(plans):
    """Multipliers by non-negative least squares, derivatives by CasADi: nothing of the solver."""
    for _, x_0, p, plan in plans[:4]:
        np.testing.assert_array_equal(p, np.tile(p[0], (len(p), 1)))
        assert kkt_residual(small_uav.problem(), plan.solution, x_0, p[0]) < 1e-4


def test_no_answer_is_worse_than_ipopts(plans):
    """IPOPT relaxes bounds by 1e-8, also those of the slacks that the penalties multiply."""
    problem = small_uav.problem()
    ipopt = CasadiSolver(problem, iteration_limit=2000)
    soft = sum(h.expression.numel() for h in problem.stage_inequalities) * problem.horizon
    relaxed = 1e-8 * FLIGHT.limit_penalty * soft
    compared = 0
    for _, x_0, p, plan in plans[:6]:
        ipopt.reset()
        # straight on, about the orbit that was chosen: it knows nothing of the answer
        straight = Guess(np.zeros_like(plan.inputs), plan.solution.decision)
        expected = ipopt.solve(x_0, p, guess=lambda straight=straight: straight)
        if expected.converged:
            compared += 1
            assert plan.solution.cost <= expected.cost * (1.0 + 1e-6) + 1.2 * relaxed
    assert compared >= 4


def test_a_stage_flies_the_shares_nearest_to_what_the_law_wants():
    parameters = small_uav.parameters()
    formulation = FlightFormulation(parameters, NO_SOLVER)
    flight, model, step = formulation.flight, formulation.model, formulation.step
    random = np.random.default_rng(3)
    clipped = 0
    for _ in range(50):
        now = small_uav.situation(
            x=random.uniform(-600.0, 600.0),
            y=random.uniform(100.0, 600.0),
            heading=random.uniform(-3.0, 3.0),
            drift=(random.uniform(-8.0, 8.0), 3.0, 0.0),
        )
        data = formulation.data(steady_forecast(now, parameters.horizon), parameters.orbit)[0]
        x_0, wanted = formulation.initial_state(now), random.uniform(-1.0, 1.0, 3)
        state = model.State(*x_0.tolist())
        middle, half = (np.array(part) for part in flight.span(state, data))
        expected = np.clip((wanted - middle) / half, -1.0, 1.0)
        clipped += np.sum(np.abs(expected) == 1.0)
        flown = [float(u) for u in flight.inputs(expected, state, data)]
        drift = Drift(now.drift.tolist(), now.drift_rate.tolist())
        numbers = model.numbers(step).tolist()
        followed = flight.law_stage(x_0, wanted, data)
        shares, following = (each.full().ravel() for each in followed)
        np.testing.assert_allclose(shares, expected, atol=1e-12)
        np.testing.assert_allclose(
            following, model.step(state, flown, step, numbers, drift), rtol=1e-12, atol=1e-12
        )
    assert 10 < clipped < 140  # inside of the box and at its bounds
