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

"""Weights for performance that keep the margins, by a search that is the same every time.

A pattern search (Hooke and Jeeves, "Direct search solution of numerical and statistical problems",
Journal of the ACM 8(2), 1961) over the logarithms of ``input_weights``, ``rate_weights`` and the
weight of the range, with that of the artificial orbit's range; only ratios count, so that the other
weights stay. Around the best weights so far each one is raised and lowered by a factor, and the
best of all these is gone on from. Where none is better the factor
becomes its square root. Weights without the margins that are asked, by the model in still air and
around the orbit in the scenario of the mismatches, are not flown; while there are no others, the
search goes towards larger margins. What flies is judged by mismatches, by range RMS, bank-rate RMS
and settling time, each as a share s of what is asked of the flight: the cost is the mean of
log2(1 + s), which is 1 where all is just what is asked, and in which one flight that fails does not
drown the others.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import islice
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.margins.margin_check import shortfalls
from uav_tracking_mpc.margins.orbit_loop import OrbitLoop
from uav_tracking_mpc.parameters.specification import ParameterError, changed
from uav_tracking_mpc.report.pages import Table
from uav_tracking_mpc.settings.configuration import load_configuration
from uav_tracking_mpc.settings.tracking import ARTIFICIAL_ORBIT, PREDICTIVE, TrackingParameters
from uav_tracking_mpc.simulation.closed_loop import simulate
from uav_tracking_mpc.simulation.plants import SimulationError
from uav_tracking_mpc.studies.comparison.asked import ASKED
from uav_tracking_mpc.studies.comparison.measures import Measures, measures
from uav_tracking_mpc.studies.comparison.results import prepared
from uav_tracking_mpc.studies.comparison.scenarios import SCENARIO, mismatched
from uav_tracking_mpc.studies.executors import parallel_map
from uav_tracking_mpc.studies.margins.margin_study import drift_of
from uav_tracking_mpc.studies.study import Study

# Range RMS [m] and bank-rate RMS [deg/s] that are asked of each flight; in gusts they are shares of
# those of another law, which would have to be flown as well: here what is asked of it is fixed.
FLIGHTS = {
    **{
        name: (ASKED[name].range_rms, ASKED[name].bank_rate_rms)
        for name in ("lag_0.5", "lag_2", "noise_2", "sensor_noise")
    },
    "gust_light": (0.3, 4.5),
    "gust_moderate": (0.7, 8.0),
}
SETTLING = 25.0  # s until the range error stays below 10 m, that is asked of each flight
DURATION, SETTLED_AFTER = 150.0, 90.0  # s, of a flight and until it counts
SIZES = {"state_weights": 5, "input_weights": 3, "rate_weights": 3, "offset_weights": 3}  # how many
# Indices, in the order of SIZES, of weights that are scaled together: range, then each of the
# inputs and rates.
MOVES = ((0, 11), (5,), (6,), (7,), (8,), (9,), (10,))
LEAST = 1e-2  # -, weight that one of 0 begins with
FACTOR, LAST_FACTOR = 10.0**0.5, 10.0**0.25  # -, of a weight, at first and in the end
ROUNDS = 12  # of the search, at most
AZIMUTHS = (0.0, 0.5 * math.pi, math.pi, 1.5 * math.pi)  # rad, at which the orbit is frozen

UNFLYABLE = 1e9  # -, cost of a flight that came to nothing
MEASURES = ("range_rms_m", "bank_rate_rms_dps", "settling_s")
SHOWN = ("range", "input_weights", "rate_weights")  # in the table
CAPTION = (
    "delay, gain: least margin of any channel, in still air and in wind; cost: 1 where every "
    "flight is just what is asked of it."
)

Weights = tuple[float, ...]


@dataclass(frozen=True)
class Candidate:
    """Weights, and what they give.

    Attributes:
        weights: All of :data:`SIZES`, one after the other.
        delay_s: Least delay margin of any channel in [s].
        gain_db: Least gain margin of any channel in [dB].
        shortfalls: Which margins are too small, in words.
        flights: Measures by the name of the flight; none where margins are too small.
        cost: 1 where every flight is just what is asked [-]; infinite where none was flown.
    """

    weights: Weights
    delay_s: float
    gain_db: float
    shortfalls: Sequence[str]
    flights: dict[str, Measures | None]
    cost: float

    @property
    def by_name(self) -> dict[str, list[float]]:
        """The weights by the names of their parameters."""
        rest = iter(self.weights)
        return {name: list(islice(rest, size)) for name, size in SIZES.items()}

    @property
    def settings(self) -> list[str]:
        """The weights as overrides of a configuration."""
        return [f"nmpc_controller.{name}={values}" for name, values in self.by_name.items()]


def search_weights(
    config: str,
    overrides: Sequence[str] = (),
    flights: Iterable[str] = FLIGHTS,
    rounds: int = ROUNDS,
    workers: int | None = None,
    show: bool = True,
) -> Study:
    """Search from the weights of a configuration on.

    Args:
        config: Name or file of the configuration.
        overrides: ``SECTION.PARAMETER=VALUE`` each.
        flights: Some of :data:`FLIGHTS`.
        rounds: Of the search, at most.
        workers: Processes; all cores by default.
        show: Progress bars on stderr.

    Raises:
        ParameterError: As of :func:`load_configuration`, or no weights that were tried have the
            margins that are asked.
    """
    overrides, flights = tuple(overrides), tuple(flights)
    configuration = load_configuration(config, overrides, SCENARIO)
    start, drift = configuration.controller, drift_of(configuration)
    if start.terminal_constraint != ARTIFICIAL_ORBIT:
        raise ParameterError(
            f"parameter 'terminal_constraint' is '{start.terminal_constraint}', must be "
            f"'{ARTIFICIAL_ORBIT}' for a search of weights"
        )
    loop, known = OrbitLoop(start), dict[Weights, Candidate]()

    def take(several: Iterable[Weights]) -> None:
        """Margins and flights of weights that are not known yet."""
        fresh = [
            _with_margins(loop, start, drift, weights)
            for weights in dict.fromkeys(several)
            if weights not in known
        ]
        sound = [candidate for candidate in fresh if not candidate.shortfalls]
        tasks = [(config, name, (*overrides, *each.settings)) for each in sound for name in flights]
        flown = iter(parallel_map(_fly, tasks, workers, "flights", show))
        for candidate in fresh:
            if not candidate.shortfalls:
                measured = {name: next(flown) for name in flights}
                candidate = replace(candidate, flights=measured, cost=_cost(measured))
            known[candidate.weights] = candidate

    def rank(candidate: Candidate) -> tuple[float, float]:
        """By least cost; where none was flown, by the margins that lack least."""
        delay = candidate.delay_s / max(start.delay_margin_min, 1e-9)
        return candidate.cost, -min(delay, candidate.gain_db / max(start.gain_margin_min, 1e-9))

    begin = [weight for name in SIZES for weight in getattr(start, name)]
    center, factor = _rounded(max(weight, LEAST) for weight in begin), FACTOR
    take([center])
    best, left = known[center], ""
    try:
        for _ in range(rounds):
            take(
                _rounded(w * scale if k in places else w for k, w in enumerate(center))
                for places in MOVES
                for scale in (factor, 1.0 / factor)
            )
            best = min(known.values(), key=rank)
            if best.weights == center:
                if factor <= LAST_FACTOR:
                    break
                factor = math.sqrt(factor)
            center = best.weights
    except KeyboardInterrupt:
        left = f"the search had tried {len(known)} weights"
    if not math.isfinite(best.cost):
        raise ParameterError(
            f"none of {len(known)} weights has the margins that are asked; the best: "
            f"{'; '.join(best.shortfalls)}"
        )
    return search_study(configuration.name, list(known.values()), best, left)


def _with_margins(
    loop: OrbitLoop, asked: TrackingParameters, drift: NDArray[np.float64], weights: Weights
) -> Candidate:
    """Weights with their margins, which are flown only if these are large enough."""
    candidate = Candidate(weights, 0.0, 0.0, (), {}, math.inf)
    loop.change(changed(asked, candidate.by_name))
    try:
        found = [loop.margins(loop.orbit_in(np.zeros(3)))]
        found += [loop.margins(loop.orbit_in(drift, phi)) for phi in AZIMUTHS]
    except ParameterError as error:
        return replace(candidate, shortfalls=[str(error)])
    channels = [channel for each in found for channel in each.channels.values()]
    return replace(
        candidate,
        delay_s=min(channel.delay_s for channel in channels),
        gain_db=min(channel.gain_db for channel in channels),
        shortfalls=[line for each in found for line in shortfalls(each, asked)],
    )


def _fly(config: str, name: str, overrides: tuple[str, ...]) -> Measures | None:
    """Measures of a flight; None where it came to nothing."""
    overrides = (*overrides, f"mission.duration={DURATION:g}")
    configuration = prepared(mismatched(config, name, overrides), PREDICTIVE)
    try:
        log = simulate(configuration)
    except SimulationError:
        return None
    return measures(log, configuration.controller, SETTLED_AFTER)


def _cost(flights: dict[str, Measures | None]) -> float:
    shares = []
    for name, flight in flights.items():
        if flight is None or flight.settling_s is None:
            return UNFLYABLE
        range_rms, bank_rate = FLIGHTS[name]
        shares += [flight.range_rms_m / range_rms, flight.bank_rate_rms_dps / bank_rate]
        shares.append(flight.settling_s / SETTLING)
    return sum(math.log2(1.0 + share) for share in shares) / len(shares)


def _rounded(weights: Iterable[float]) -> Weights:
    """Two digits: what is printed is what was flown."""
    return tuple(float(f"{weight:.2g}") for weight in weights)


def search_study(
    config: str, candidates: Sequence[Candidate], best: Candidate, left: str = ""
) -> Study:
    """What was tried with a configuration, a row for each; the best, and the YAML to paste."""
    weights = [f"    {name}: {values}" for name, values in best.by_name.items()]
    yaml = "\n".join(["/**/nmpc_controller:", "  ros__parameters:", *weights])
    columns = ("delay [s]", "gain [dB]", "cost")
    rows = [
        [
            f"{each.by_name['state_weights'][0]:g}",
            *(", ".join(f"{weight:g}" for weight in each.by_name[name]) for name in SHOWN[1:]),
            f"{each.delay_s:.2f}",
            f"{each.gain_db:.1f}",
            f"{each.cost:.3f}" if math.isfinite(each.cost) else "too small margins",
        ]
        for each in candidates
    ]
    table = Table((*SHOWN, *columns), rows, numeric=columns, caption=CAPTION)
    content = {
        "config": config,
        "candidates": [_numbers(each) for each in candidates],
        "best": _numbers(best),
        "yaml": yaml,
    }
    return Study("search", content, [table, yaml], left=left)


def _numbers(candidate: Candidate) -> dict[str, Any]:
    return {
        **candidate.by_name,
        "delay_s": candidate.delay_s,
        "gain_db": candidate.gain_db,
        "shortfalls": candidate.shortfalls,
        "cost": candidate.cost,
        "flights": {
            name: flight and {measure: getattr(flight, measure) for measure in MEASURES}
            for name, flight in candidate.flights.items()
        },
    }
