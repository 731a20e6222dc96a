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

"""What holds for the problem with the artificial orbit, and flights that show it."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import islice, pairwise
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from uav_tracking_mpc.estimation.situation import Situation
from uav_tracking_mpc.formulation.flight_formulation import FlightFormulation
from uav_tracking_mpc.mpc.solver import solutions
from uav_tracking_mpc.settings.configuration import Configuration
from uav_tracking_mpc.settings.tracking import ARTIFICIAL_ORBIT, TrackingParameters
from uav_tracking_mpc.studies.executors import parallel_map
from uav_tracking_mpc.studies.flight_start import flight_start

PREMISE = "The aircraft flies as predicted; solves converge, to no worse than the plan continued."

GUARANTEED = (
    "Commands keep to turn rate (bank, yaw rate), path-angle rate and specific force at every "
    "stage: the inputs are shares of what these limits leave in the stage's state.",
    "Feasible once is feasible for ever, without drift: the plan ends on an orbit that the "
    "optimiser chose among those that can be flown all the way round, with that orbit's rates. Its "
    "steady inputs, held, stay on it: the rest of the plan and one more step of the orbit are a "
    "plan again.",
    "The optimal cost falls by at least the stage cost, without drift: that plan costs as much "
    "less, since on the orbit nothing is paid but its distance to the wanted one, and the optimum "
    "costs no more. It takes an orbit that itself keeps the soft limits.",
)

NOT_GUARANTEED = (
    "In a steady drift the turn rate changes round the orbit, and inputs held for a step leave it "
    "by a little: there feasibility and fall of the cost are no theorems, only counted.",
    "Airspeed, path angle, height, distance and fence are exact soft constraints: kept wherever "
    "they can be, since a flight may begin outside of them.",
    "What the aircraft makes of commands: its lag lets path-angle rate and acceleration follow "
    "differently, and their common limit, the specific force, is passed for moments.",
    "Gusts, a wind or target that changes, another aircraft than predicted, a solve that ends "
    "before it converges: there the controller's fallback modes hold.",
)

ANALYSIS = (
    "The ellipsoid x'P_rho x <= varrho of the paper's analysis is not part of this problem: there "
    "is no level to certify and no certificate to verify."
)


def as_words() -> str:
    """All of it, for people."""
    lines = [ANALYSIS, "", f"Guaranteed. {PREMISE}"]
    lines += [f"  {index}. {words}" for index, words in enumerate(GUARANTEED, 1)]
    lines += ["", "Not guaranteed."]
    lines += [f"  - {words}" for words in NOT_GUARANTEED]
    return "\n".join(lines)


NEAREST, FARTHEST = 0.2, 3.3  # -, of r_d
LOWEST, HIGHEST = -0.3, 0.45  # -, of r_d, from z_d
STEEPEST = 0.95  # -, ratio |z| / r
DRIFT_SHARE = 0.4  # -, of the airspeed, the strongest drift
STILL_SHARE = 0.3  # -, of the states, without drift


def random_situations(parameters: TrackingParameters, count: int, seed: int = 0) -> list[Situation]:
    """Situations inside the envelope: any heading, any turn, no climb under way.

    Args:
        parameters: Orbit and limits.
        count: How many.
        seed: Of the generator.
    """
    generator = np.random.default_rng(seed)
    return [_random_situation(parameters, generator) for _ in range(count)]


def _random_situation(p: TrackingParameters, generator: np.random.Generator) -> Situation:
    distance = generator.uniform(max(NEAREST * p.range, p.distance_min), FARTHEST * p.range)
    lowest = max(p.altitude + LOWEST * p.range, p.height_min)
    height = generator.uniform(lowest, max(lowest, p.altitude + HIGHEST * p.range))
    height = min(max(height, -STEEPEST * distance), STEEPEST * distance)
    level = math.sqrt(distance**2 - height**2)
    azimuth, heading, blowing = generator.uniform(-math.pi, math.pi, 3)
    airspeed = generator.uniform(p.airspeed_min, p.airspeed_max)
    path_angle = generator.uniform(p.path_angle_min, p.path_angle_max)
    turning = p.envelope.turn_rate_max(airspeed)
    drift = generator.uniform(0.0, DRIFT_SHARE) * min(airspeed, p.airspeed)
    if generator.random() < STILL_SHARE:
        drift = 0.0
    return Situation(
        vehicle=np.array(
            [
                level * math.cos(azimuth),
                level * math.sin(azimuth),
                height,
                heading,
                path_angle,
                airspeed,
            ]
        ),
        target=np.zeros(3),
        drift=drift * np.array([math.cos(blowing), math.sin(blowing), 0.0]),
        drift_rate=np.zeros(3),
        rates=np.array([generator.uniform(-turning, turning), 0.0, 0.0]),
    )


STEPS = 40  # of a flight
FEASIBLE = 1e-5  # -, largest violation of a hard constraint, scaled: 0.1 mm, 1e-5 rad or m/s
# -, tolerance of the solvers: what a cost may rise by it, relative and absolute.
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


def feasibility_study(
    configuration: Configuration, count: int = 0, workers: int | None = None
) -> dict[str, Any]:
    """Say what is guaranteed and fly random states.

    Args:
        configuration: With the terminal constraint ``artificial_orbit``.
        count: Random states to fly; 0 for none.
        workers: Processes; all cores by default.

    Returns:
        Plain values: ``config``, ``terminal_constraint``, ``premise``, ``guaranteed``,
        ``not_guaranteed``; with a campaign also ``clean`` (nothing happened that is guaranteed not
        to) and what :func:`~uav_tracking_mpc.studies.feasibility_study.summary`
        returns.
    """
    content: dict[str, Any] = {
        "config": configuration.name,
        "terminal_constraint": ARTIFICIAL_ORBIT,
        "premise": PREMISE,
        "guaranteed": list(GUARANTEED),
        "not_guaranteed": list(NOT_GUARANTEED),
    }
    if count:
        situations = random_situations(configuration.controller, count)
        content |= summary(campaign(configuration.controller, situations, workers=workers))
        content["clean"] = _clean(content["without_drift"])
    return content


def _clean(counts: dict[str, Any]) -> bool:
    """Whether nothing happened that is guaranteed not to; it takes a first plan."""
    begun = counts["steps"] - counts["cold_failures"]
    return bool(counts["feasible"] >= begun and counts["cost_rises"] == 0)


def in_words(content: dict[str, Any]) -> list[str]:
    """The study for people.

    Args:
        content: What :func:`feasibility_study` returned.
    """
    lines = [as_words()]
    if "clean" not in content:
        return lines
    lines.append("")
    for title, counts in (
        ("all flights", content),
        ("those without drift", content["without_drift"]),
    ):
        lines.append(
            f"{title}: {counts['states']} states, {counts['cold_failures']} of them without a "
            f"first plan; {counts['steps']} solves, {counts['converged']} converged, "
            f"{counts['feasible']} feasible; the cost rose {counts['cost_rises']} times, at most "
            f"by {counts['worst_rise']:.3g}"
        )
    for name in ("cold", "warm"):
        times = content[f"{name}_us"]
        if times["median"] is not None:
            lines.append(
                f"{name}: median {times['median']:.0f} us, 99 % below {times['p99']:.0f} us"
            )
    return lines
