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

"""How often identification is right: simulated flights with lags drawn at random.

Heading, path angle and airspeed are measured with noise. The simulator measures its rates exactly;
they are withheld, since no gyroscope is. What the controller is told is wrong by up to a factor of
two, as it is before an aircraft has been identified.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from uav_tracking_mpc.parameters.specification import changed
from uav_tracking_mpc.report.pages import Table
from uav_tracking_mpc.settings.configuration import Configuration, load_configuration
from uav_tracking_mpc.settings.tracking import USUAL_EXCITATION
from uav_tracking_mpc.simulation.closed_loop import simulate
from uav_tracking_mpc.studies.executors import parallel_map
from uav_tracking_mpc.studies.identification.flight_record import CHANNELS, FlightRecord, Samples
from uav_tracking_mpc.studies.identification.identification import identify
from uav_tracking_mpc.studies.identification.profile_intervals import CONFIDENCE, Estimates
from uav_tracking_mpc.studies.identification.record_files import FlightWitness
from uav_tracking_mpc.studies.study import Study

SCENARIO = "crosswind"
DURATION, EXCITED = 120.0, 60.0  # s of a flight, and of its end that are used
LAG, DEAD_TIME, GAIN = (0.05, 1.0), (0.0, 0.3), (0.8, 1.25)  # s, s, -: drawn from
TOLD = 2.0  # -, greatest factor by which lag and dead time are given wrong
# s, -: how near an estimate must come, also as a share of the truth.
NEAR = {"total": (0.03, 0.05), "lag": (0.06, 0.15), "dead_time": (0.06, 0.15)}
# m/s, rad, m/s: noise of the sensors
NOISE = {"velocity_noise": 0.3, "attitude_noise": math.radians(0.5), "airspeed_noise": 0.3}


class Truth(NamedTuple):
    """What the simulated aircraft does.

    Attributes:
        lag: tau of each channel, three values in [s].
        dead_time: D of each channel, three values in [s].
        gain: G of each channel, three values [-].
    """

    lag: tuple[float, ...]
    dead_time: tuple[float, ...]
    gain: tuple[float, ...]

    def of(self, channel: int) -> dict[str, float]:
        """The figures of one channel by the names of :class:`Estimates`.

        Args:
            channel: Its number.
        """
        lag, dead_time = self.lag[channel], self.dead_time[channel]
        return {
            "lag": lag,
            "dead_time": dead_time,
            "total": lag + dead_time,
            "gain": self.gain[channel],
        }


class Flight(NamedTuple):
    """A flight to be flown.

    Attributes:
        config: Name or file of the configuration.
        overrides: ``SECTION.PARAMETER=VALUE`` each.
        seed: Of everything that is drawn.
    """

    config: str
    overrides: tuple[str, ...]
    seed: int


class Identified(NamedTuple):
    """A flight that was flown.

    Attributes:
        truth: What was to be found.
        found: Of each channel.
    """

    truth: Truth
    found: dict[str, Estimates]


def drawn(flight: Flight) -> tuple[Configuration, Truth]:
    """The configuration of a flight, and what is to be found.

    Args:
        flight: To be flown.
    """
    random = np.random.default_rng(flight.seed)
    shortest, longest = np.log(LAG).tolist()
    lag = np.exp(random.uniform(shortest, longest, 3))
    dead_time, gain = random.uniform(*DEAD_TIME, 3), random.uniform(*GAIN, 3)
    told = np.exp(random.uniform(-math.log(TOLD), math.log(TOLD), (2, 3)))
    configuration = load_configuration(flight.config, flight.overrides, SCENARIO)
    truth = Truth(*(tuple(values.tolist()) for values in (lag, dead_time, gain)))
    true: dict[str, Any] = {
        "rate_lag": truth.lag,
        "dead_time": truth.dead_time,
        "command_gain": truth.gain,
        "seed": flight.seed,
        **NOISE,
    }
    told_lag, told_dead_time = (told * (lag, dead_time)).tolist()
    believed = {"rate_lag": told_lag, "dead_time": told_dead_time, "excitation": USUAL_EXCITATION}
    drawn_configuration = replace(
        configuration,
        simulator=changed(configuration.simulator, true),
        controller=changed(configuration.controller, believed),
        mission=replace(configuration.mission, duration=DURATION),
    )
    return drawn_configuration, truth


def fly(flight: Flight) -> Identified:
    """Fly and identify.

    Args:
        flight: To be flown.
    """
    configuration, truth = drawn(flight)
    witness = FlightWitness()
    simulate(configuration, witness=witness)
    found = identify(_used(witness.record()).channels())
    return Identified(truth, {channel.name: channel.estimates for channel in found})


def _used(record: FlightRecord) -> FlightRecord:
    """What of a record is used: no rates, and nothing measured before the excitation."""

    def last(samples: Samples) -> Samples:
        kept = samples.time > samples.time[-1] - EXCITED
        return Samples(samples.time[kept], samples.value[kept])

    assert record.airspeed is not None
    return replace(
        record,
        heading=last(record.heading),
        path_angle=last(record.path_angle),
        airspeed=last(record.airspeed),
        turn_rate=None,
        path_angle_rate=None,
    )


def validate(
    config: str,
    overrides: Sequence[str] = (),
    count: int = 40,
    seed: int = 0,
    workers: int | None = None,
) -> dict[str, Any]:
    """Fly, identify and count.

    Args:
        config: Name or file of the configuration.
        overrides: ``SECTION.PARAMETER=VALUE`` each.
        count: How many flights.
        seed: Of the first; the others follow.
        workers: Processes; one for each core by default.

    Returns:
        ``channels.<name>.near`` and ``.covered``: share of the flights in which an estimate came
        near enough and in which its interval held the truth, by name of the figure;
        ``.errors``: of each flight.
    """
    flights = [Flight(config, tuple(overrides), seed + index) for index in range(count)]
    flown = parallel_map(fly, flights, workers, "flights")
    return {
        "config": config,
        "flights": count,
        "seed": seed,
        "confidence": CONFIDENCE,
        "channels": {name: _counted(index, name, flown) for index, name in enumerate(CHANNELS)},
    }


def _counted(index: int, name: str, flown: Sequence[Identified]) -> dict[str, Any]:
    pairs = [(one.truth.of(index), one.found[name]._asdict()) for one in flown]
    return {
        "near": {
            figure: _share(
                abs(found[figure].value - truth[figure]) <= max(least, share * truth[figure])
                for truth, found in pairs
            )
            for figure, (least, share) in NEAR.items()
        },
        "covered": {
            figure: _share(found[figure].holds(truth[figure]) for truth, found in pairs)
            for figure in Estimates._fields
        },
        "errors": [
            {
                figure: {"truth": truth[figure], **found[figure]._asdict()}
                for figure in Estimates._fields
            }
            for truth, found in pairs
        ],
    }


def _share(hits: Iterable[bool]) -> float:
    counted = list(hits)
    return sum(counted) / len(counted)


def validation(content: dict[str, Any]) -> Study:
    """The study: the counts, and a table of their shares with one row a channel.

    Args:
        content: Of :func:`validate`.
    """
    near = [
        f"{name.replace('_', ' ')} within {least:g} s or {share:.0%}"
        for name, (least, share) in NEAR.items()
    ]
    covered = [f"interval holds {name.replace('_', ' ')}" for name in Estimates._fields]
    rows = [
        [name, *(f"{share:.1%}" for share in (*c["near"].values(), *c["covered"].values()))]
        for name, c in content["channels"].items()
    ]
    table = Table(
        ["channel", *near, *covered],
        rows,
        numeric=(*near, *covered),
        title=f"{content['flights']} flights, {EXCITED:g} s of each",
    )
    return Study("validation", content, [table], tables={"identification": table})
