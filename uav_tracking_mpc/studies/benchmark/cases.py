"""The problems of the benchmark: the paper's at two horizons, with and without X_f, and flight."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.dynamics.discretisation import error_dynamics, linearise
from uav_tracking_mpc.dynamics.orbit import Orbit
from uav_tracking_mpc.dynamics.relative import steady_inputs, tracking_error
from uav_tracking_mpc.mpc.problem import OptimalControlProblem
from uav_tracking_mpc.mpc.quadratic import TerminalSet, quadratic_problem
from uav_tracking_mpc.studies.benchmark.flight_case import DRIFT, flight_problem, flight_state
from uav_tracking_mpc.terminal.ingredients import input_limited_level, terminal_ingredients

ORBIT = Orbit(150.0, 50.0, 4.0)  # Table 1
STATE_WEIGHT = np.diag([0.008, 0.09, 0.05, 0.04, 0.9])
INPUT_WEIGHT = np.eye(3)
SCALING = 2.5  # rho
INPUT_LIMITS = np.array([math.pi / 4, math.pi / 4, 1.0])  # [rad/s, rad/s, m/s^2]
PENALTY = 100.0  # of leaving the terminal ellipsoid
START = np.array([212.83, -math.pi / 4, 20.0, 0.0, 0.0])  # x_o: (r, theta, z, chi, v)


@dataclass(frozen=True)
class Case:
    """A problem and where it is solved.

    Attributes:
        name: Key in the JSON.
        problem: What is solved.
        start: Where the transient begins, shape (nx,).
        state: Of the problem, from (r, theta, z, chi, v) and an azimuth.
        parameters: Of every stage, or None.
    """

    name: str
    problem: OptimalControlProblem
    start: NDArray[np.float64]
    state: Callable[[NDArray[np.float64], float], NDArray[np.float64]]
    parameters: NDArray[np.float64] | None = None

    def plant(self) -> Callable[[NDArray[np.float64], NDArray[np.float64]], NDArray[np.float64]]:
        """x+ = f(x, u): the model itself."""
        problem = self.problem
        step = ca.Function(
            "plant", [problem.state, problem.inputs, problem.parameter], [problem.next_state]
        )
        p = np.zeros(problem.np) if self.parameters is None else self.parameters
        return lambda x, u: np.array(step(x, u, p)).ravel()

    def cold_states(self, count: int, seed: int) -> NDArray[np.float64]:
        """Random states, shape (count, nx), from near to far and in every direction."""
        random = np.random.default_rng(seed)
        return np.array([self.state(*_random_relative_state(random)) for _ in range(count)])


def _random_relative_state(random: np.random.Generator) -> tuple[NDArray[np.float64], float]:
    r = random.uniform(80.0, 400.0)
    theta = random.uniform(-math.pi, math.pi)
    z = min(random.uniform(10.0, 120.0), 0.8 * r)
    chi = random.uniform(-0.4, 0.4)
    v = random.uniform(1.0, 8.0)
    return np.array([r, theta, z, chi, v]), random.uniform(-math.pi, math.pi)


def paper_problem(horizon: int, ellipsoid: bool = False) -> OptimalControlProblem:
    """(16) with Table 1, the exact model under Euler steps of 1 s; X_f soft or absent."""
    dynamics = error_dynamics("exact", ORBIT, 1.0)
    ingredients = terminal_ingredients(*linearise(dynamics), STATE_WEIGHT, INPUT_WEIGHT, SCALING)
    steady = steady_inputs("exact", ORBIT)
    lower, upper = -INPUT_LIMITS - steady, INPUT_LIMITS - steady
    level = input_limited_level(ingredients, lower, upper)
    return quadratic_problem(
        dynamics,
        horizon=horizon,
        step=1.0,
        state_weight=STATE_WEIGHT,
        input_weight=INPUT_WEIGHT,
        terminal_weight=ingredients.weight,
        input_lower=lower,
        input_upper=upper,
        terminal_set=TerminalSet(level, PENALTY) if ellipsoid else None,
    )


def paper_case(horizon: int, ellipsoid: bool = False) -> Case:
    """The paper's problem and start."""
    return Case(
        name=f"paper_n{horizon}{'_ellipsoid' if ellipsoid else ''}",
        problem=paper_problem(horizon, ellipsoid),
        start=tracking_error(START, ORBIT),
        state=lambda relative, azimuth: tracking_error(relative, ORBIT),
    )


def flight_case() -> Case:
    """The flight problem, N = 20, from the paper's start."""
    return Case(
        name="flight_n20",
        problem=flight_problem(20),
        start=flight_state(START, 0.0),
        state=flight_state,
        parameters=DRIFT,
    )


def cases() -> list[Case]:
    """All cases, in the order in which they are reported."""
    return [
        paper_case(10),
        paper_case(10, ellipsoid=True),
        paper_case(30),
        paper_case(30, ellipsoid=True),
        flight_case(),
    ]
