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

"""Fly many random states in closed loop on the prediction itself: does what is guaranteed show?

The next state is the plan's next state. Without drift every solve is to be feasible and the optimal
cost is never to rise; in a steady drift both are observations.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import islice, pairwise
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from uav_tracking_mpc.estimation.situation import Situation
from uav_tracking_mpc.formulation.flight_formulation import FlightFormulation
from uav_tracking_mpc.mpc.prediction_loop import solutions
from uav_tracking_mpc.settings.tracking import TrackingParameters
from uav_tracking_mpc.studies.flight_start import flight_start
from uav_tracking_mpc.studies.parallel import parallel_map

STEPS = 40  # of a flight
FEASIBLE = 1e-5  # largest violation of a hard constraint, scaled: 0.1 mm, 1e-5 rad or m/s
# Solvers stop at a tolerance: what a cost may rise by it, relative and absolute [-].
RELATIVE_RISE, RISE = 1e-6, 1e-5
SOLVE_TIME_MAX = 10.0  # s; with a budget the load of the machine would decide what is counted
PIECE = 50  # flights


@dataclass(frozen=True)
class FlightCounts:
    """One flight.

    Attributes:
        drifting: Whether there was a drift.
        cold_failure: Whether the first solve did not converge; the flight then ends there.
        steps: Solves.
        converged: Solves that converged.
        feasible: Solves whose plan keeps the hard constraints.
        cost_rises: Solves whose cost is above that of the one before.
        worst_rise: Largest difference [-], 0 if there is none.
        cold_us: Wall time of the first solve in [us].
        warm_us: Of the others in [us].
    """

    drifting: bool
    cold_failure: bool
    steps: int
    converged: int
    feasible: int
    cost_rises: int
    worst_rise: float
    cold_us: float
    warm_us: tuple[float, ...]


def campaign(
    parameters: TrackingParameters,
    situations: Sequence[Situation],
    steps: int = STEPS,
    workers: int | None = None,
    show: bool = True,
) -> list[FlightCounts]:
    """Fly closed loops.

    Args:
        parameters: Of a problem with an artificial orbit.
        situations: Where they begin.
        steps: Solves of every flight.
        workers: Processes; all cores by default, 1 stays in this one.
        show: Progress bar on stderr.
    """
    parameters = dataclasses.replace(parameters, solve_time_max=SOLVE_TIME_MAX)
    pieces = [
        (parameters, situations[begin : begin + PIECE], steps)
        for begin in range(0, len(situations), PIECE)
    ]
    parts = parallel_map(_fly_piece, pieces, workers, f"{PIECE} flights a piece", show)
    return [flight for part in parts for flight in part]


def summary(flights: Sequence[FlightCounts]) -> dict[str, Any]:
    """Sums over flights: plain values, never NaN.

    Args:
        flights: Any number of them.

    Returns:
        - ``states``, and of these ``cold_failures``: their first solve did not converge
        - ``steps``: all solves, and of these ``converged``, ``feasible``, ``cost_rises``
        - ``worst_rise``; ``cold_us`` and ``warm_us`` with ``median`` and ``p99``
        - ``without_drift``: the counts of the flights without drift
    """
    still = [flight for flight in flights if not flight.drifting]
    return {
        **_counts(flights),
        "cold_us": _times([flight.cold_us for flight in flights]),
        "warm_us": _times([time for flight in flights for time in flight.warm_us]),
        "without_drift": _counts(still),
    }


def _counts(flights: Sequence[FlightCounts]) -> dict[str, Any]:
    return {
        "states": len(flights),
        "cold_failures": sum(flight.cold_failure for flight in flights),
        "steps": sum(flight.steps for flight in flights),
        "converged": sum(flight.converged for flight in flights),
        "feasible": sum(flight.feasible for flight in flights),
        "cost_rises": sum(flight.cost_rises for flight in flights),
        "worst_rise": max((flight.worst_rise for flight in flights), default=0.0),
    }


def _times(microseconds: ArrayLike) -> dict[str, float | None]:
    values = np.asarray(microseconds, dtype=float)
    if not values.size:
        return {"median": None, "p99": None}
    return {"median": float(np.median(values)), "p99": float(np.percentile(values, 99.0))}


def _fly_piece(piece: tuple[TrackingParameters, Sequence[Situation], int]) -> list[FlightCounts]:
    parameters, situations, steps = piece
    formulation = _formulation(parameters)
    return [_fly(formulation, situation, steps) for situation in situations]


@lru_cache(maxsize=1)
def _formulation(parameters: TrackingParameters) -> FlightFormulation:
    """One for all pieces of a process."""
    return FlightFormulation(parameters)


def _fly(formulation: FlightFormulation, situation: Situation, steps: int) -> FlightCounts:
    start = flight_start(formulation, situation)
    loop = solutions(formulation.solver, start.state, start.parameters, start.guess)
    flown = [next(loop)]
    if flown[0].converged:
        flown += islice(loop, steps - 1)
    costs = [solution.cost for solution in flown]
    rises = [
        cost - before
        for before, cost in pairwise(costs)
        if not cost <= before * (1.0 + RELATIVE_RISE) + RISE
    ]
    cold, *warm = (1e6 * solution.solve_time for solution in flown)
    return FlightCounts(
        drifting=bool(np.any(situation.drift)),
        cold_failure=not flown[0].converged,
        steps=len(flown),
        converged=sum(solution.converged for solution in flown),
        feasible=sum(solution.violation <= FEASIBLE for solution in flown),
        cost_rises=len(rises),
        worst_rise=max(rises, default=0.0),
        cold_us=cold,
        warm_us=tuple(warm),
    )
