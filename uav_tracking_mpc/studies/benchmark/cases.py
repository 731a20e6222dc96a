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

"""The problems of the benchmark, all of them flown: the paper's and that of a small aircraft."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.dynamics.relative import tracking_error
from uav_tracking_mpc.estimation.situation import Situation
from uav_tracking_mpc.formulation.flight_formulation import FlightFormulation
from uav_tracking_mpc.formulation.paper_formulation import problem_of
from uav_tracking_mpc.mpc.problem import OptimalControlProblem
from uav_tracking_mpc.settings.configuration import load_configuration
from uav_tracking_mpc.studies.feasibility_study import random_situations
from uav_tracking_mpc.studies.flight_start import Start, flight_start
from uav_tracking_mpc.terminal.ingredients import PAPER_INITIAL_STATE


@dataclass(frozen=True)
class Case:
    """A problem and where it is solved.

    Attributes:
        name: Key in the JSON.
        problem: What is solved.
        start: Where the transient begins.
        cold_starts: Random starts, from their number and a seed.
    """

    name: str
    problem: OptimalControlProblem
    start: Start
    cold_starts: Callable[[int, int], list[Start]]


def paper_problem(horizon: int, ellipsoid: bool = False) -> OptimalControlProblem:
    """(16) with the parameters of ``config/paper.yaml``.

    Args:
        horizon: N [-].
        ellipsoid: With X_f as a soft constraint; else without.
    """
    constraint = "soft" if ellipsoid else "none"
    parameters = load_configuration("paper").controller
    return problem_of(
        dataclasses.replace(parameters, horizon=horizon, terminal_constraint=constraint)
    )


def paper_case(horizon: int, ellipsoid: bool = False) -> Case:
    """The paper's problem and start.

    Args:
        horizon: N [-].
        ellipsoid: With X_f as a soft constraint; else without.
    """
    return Case(
        name=f"paper_n{horizon}{'_ellipsoid' if ellipsoid else ''}",
        problem=paper_problem(horizon, ellipsoid),
        start=_paper_start(PAPER_INITIAL_STATE),
        cold_starts=_paper_cold_starts,
    )


def _paper_start(relative: NDArray[np.float64]) -> Start:
    """Start from (r, theta, z, chi, v), shape (5,)."""
    return Start(tracking_error(relative, load_configuration("paper").controller.orbit))


def _paper_cold_starts(count: int, seed: int) -> list[Start]:
    """From near to far and in every direction."""
    random = np.random.default_rng(seed)
    orbit = load_configuration("paper").controller.orbit
    return [Start(tracking_error(_random_relative_state(random), orbit)) for _ in range(count)]


def _random_relative_state(random: np.random.Generator) -> NDArray[np.float64]:
    r = random.uniform(80.0, 400.0)
    theta = random.uniform(-math.pi, math.pi)
    z = min(random.uniform(10.0, 120.0), 0.8 * r)
    chi = random.uniform(-0.4, 0.4)
    v = random.uniform(1.0, 8.0)
    return np.array([r, theta, z, chi, v])


def flight_case(horizon: int = 20) -> Case:
    """The flight problem of ``config/small_uav.yaml``, in the formulation that flies.

    The transient begins where the configuration's simulator does, in still air; the cold starts are
    :func:`~uav_tracking_mpc.studies.feasibility_study.random_situations`, most of them in
    a drift.

    Args:
        horizon: N [-].
    """
    configuration = load_configuration("small_uav")
    parameters = dataclasses.replace(configuration.controller, horizon=horizon)
    formulation = FlightFormulation(parameters)
    still = np.zeros(3)
    begin = Situation(configuration.simulator.initial_state, still, still, still, still)

    def cold_starts(count: int, seed: int) -> list[Start]:
        situations = random_situations(parameters, count, seed)
        return [flight_start(formulation, situation) for situation in situations]

    return Case(
        name=f"flight_n{horizon}",
        problem=formulation.solver.problem,
        start=flight_start(formulation, begin),
        cold_starts=cold_starts,
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
