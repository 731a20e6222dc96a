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
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import islice, pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.control.guidance import nearest_direction
from uav_tracking_mpc.estimation.situation import Situation, steady_forecast
from uav_tracking_mpc.formulation.flight_formulation import FlightFormulation
from uav_tracking_mpc.mpc.solver import Guess, solutions
from uav_tracking_mpc.report.metrics import microseconds
from uav_tracking_mpc.settings.configuration import Configuration
from uav_tracking_mpc.settings.tracking import ARTIFICIAL_ORBIT, NEAREST, TrackingParameters
from uav_tracking_mpc.studies.executors import parallel_map
from uav_tracking_mpc.studies.study import Study

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


@dataclass(frozen=True)
class Start:
    """What a solver is given to begin.

    Attributes:
        state: x_0, shape (nx,).
        parameters: P of every stage, shape (N + 1, np); None where the problem has none.
        guess: Plan for a cold start from a state, shape (nx,); None leaves it to the solver.
    """

    state: NDArray[np.float64]
    parameters: NDArray[np.float64] | None = None
    guess: Callable[[NDArray[np.float64]], Guess | None] | None = None


def flight_start(formulation: FlightFormulation, situation: Situation) -> Start:
    """Begin at a situation whose drift stays, about a target that stays."""
    parameters = formulation.parameters
    forecast = steady_forecast(situation, parameters.horizon)
    orbit = parameters.orbit
    if parameters.direction == NEAREST:
        orbit = dataclasses.replace(orbit, direction=nearest_direction(situation))
    data = formulation.data(forecast, orbit).copy()

    def guess(state: NDArray[np.float64]) -> Guess | None:
        return formulation.guess(state, forecast, orbit, data)

    return Start(formulation.initial_state(situation), data, guess)


NEAR, FAR = 0.2, 3.3  # -, of r_d
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
    distance = generator.uniform(max(NEAR * p.range, p.distance_min), FAR * p.range)
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
# Summed over flights: first solves that did not converge, which end a flight; all solves, and of
# these those that converged, whose plan keeps the hard constraints, whose cost rose.
COUNTED = ("cold_failures", "steps", "converged", "feasible", "cost_rises")

Row = dict[str, Any]


def campaign(
    parameters: TrackingParameters,
    situations: Sequence[Situation],
    steps: int = STEPS,
    workers: int | None = None,
    show: bool = True,
) -> list[Row]:
    """Fly closed loops of a problem with an artificial orbit.

    Args:
        parameters: Of the problem.
        situations: Where the flights begin.
        steps: Solves of every flight.
        workers: Processes; all cores by default, 1 stays in this one.
        show: Progress bar on stderr.

    Returns:
        Of each flight: :data:`COUNTED`; ``drifting``, whether there was a drift; ``worst_rise`` of
        the cost [-]; wall times in [s], ``cold`` of the first solve and ``warm`` of the others.
        Where the user interrupted, of the flights that were flown.
    """
    parameters = dataclasses.replace(parameters, solve_time_max=SOLVE_TIME_MAX)
    tasks = [(parameters, situation, steps) for situation in situations]
    return parallel_map(_fly, tasks, workers, "flights", show, least=1)


def summary(flights: Sequence[Row]) -> dict[str, Any]:
    """Sums over flights: plain values, never NaN.

    Returns:
        - ``states``, :data:`COUNTED` and ``worst_rise``
        - ``cold_us`` and ``warm_us`` with ``median`` and ``p99``
        - ``without_drift``: the counts of the flights without drift
    """
    return {
        **_counts(flights),
        "cold_us": _times([flight["cold"] for flight in flights]),
        "warm_us": _times([time for flight in flights for time in flight["warm"]]),
        "without_drift": _counts([flight for flight in flights if not flight["drifting"]]),
    }


def _counts(flights: Sequence[Row]) -> dict[str, Any]:
    return {
        "states": len(flights),
        **{name: sum(flight[name] for flight in flights) for name in COUNTED},
        "worst_rise": max((flight["worst_rise"] for flight in flights), default=0.0),
    }


def _times(seconds: Sequence[float]) -> dict[str, float | None]:
    found = microseconds(np.array(seconds))
    return {name: found[f"{name}_us"] for name in ("median", "p99")}


@lru_cache(maxsize=1)
def _formulation(parameters: TrackingParameters) -> FlightFormulation:
    """One for all flights of a process."""
    return FlightFormulation(parameters)


def _fly(parameters: TrackingParameters, situation: Situation, steps: int) -> Row:
    formulation = _formulation(parameters)
    start = flight_start(formulation, situation)
    loop = solutions(formulation.solver, start.state, start.parameters, start.guess)
    flown = [next(loop)]
    if flown[0].converged:
        flown += islice(loop, steps - 1)
    rises = [
        solution.cost - before.cost
        for before, solution in pairwise(flown)
        if not solution.cost <= before.cost * (1.0 + RELATIVE_RISE) + RISE
    ]
    cold, *warm = (solution.solve_time for solution in flown)
    return {
        "drifting": bool(np.any(situation.drift)),
        "cold_failures": int(not flown[0].converged),
        "steps": len(flown),
        "converged": sum(solution.converged for solution in flown),
        "feasible": sum(solution.violation <= FEASIBLE for solution in flown if flown[0].converged),
        "cost_rises": len(rises),
        "worst_rise": max(rises, default=0.0),
        "cold": cold,
        "warm": warm,
    }


def feasibility_study(
    configuration: Configuration, count: int = 0, workers: int | None = None
) -> Study:
    """Say what is guaranteed and fly random states.

    Args:
        configuration: With the terminal constraint ``artificial_orbit``.
        count: Random states to fly; 0 for none.
        workers: Processes; all cores by default.

    Returns:
        Its content: ``config``, ``terminal_constraint``, ``premise``, ``guaranteed``,
        ``not_guaranteed``; with a campaign also ``clean`` (nothing happened that is guaranteed not
        to; it takes a first plan) and what :func:`summary` returns.
    """
    content: dict[str, Any] = {
        "config": configuration.name,
        "terminal_constraint": ARTIFICIAL_ORBIT,
        "premise": PREMISE,
        "guaranteed": list(GUARANTEED),
        "not_guaranteed": list(NOT_GUARANTEED),
    }
    words = [
        *(ANALYSIS, "", f"Guaranteed. {PREMISE}"),
        *(f"  {index}. {line}" for index, line in enumerate(GUARANTEED, 1)),
        *("", "Not guaranteed."),
        *(f"  - {line}" for line in NOT_GUARANTEED),
    ]
    if count:
        situations = random_situations(configuration.controller, count)
        content |= summary(campaign(configuration.controller, situations, workers=workers))
        still = content["without_drift"]
        begun = still["steps"] - still["cold_failures"]
        content["clean"] = bool(still["feasible"] >= begun and still["cost_rises"] == 0)
        words += ["", *_words(content)]
    flown = content.get("states", count)
    left = f"{flown} of {count} states were flown" if flown < count else ""
    return Study("stability", content, words, good=content.get("clean", True), left=left)


def _words(content: dict[str, Any]) -> list[str]:
    """What the flights showed."""
    parts = {"all flights": content, "those without drift": content["without_drift"]}
    lines = [
        "{title}: {states} states, {cold_failures} of them without a first plan; {steps} solves, "
        "{converged} converged, {feasible} feasible; the cost rose {cost_rises} times, at most by "
        "{worst_rise:.3g}".format(title=title, **counts)
        for title, counts in parts.items()
    ]
    times = {name: content[f"{name}_us"] for name in ("cold", "warm")}
    return lines + [
        f"{name}: median {each['median']:.0f} us, 99 % below {each['p99']:.0f} us"
        for name, each in times.items()
        if each["median"] is not None
    ]
