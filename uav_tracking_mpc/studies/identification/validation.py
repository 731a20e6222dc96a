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
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.parameters.specification import changed
from uav_tracking_mpc.report.pages import Table
from uav_tracking_mpc.settings.configuration import Configuration, load_configuration
from uav_tracking_mpc.settings.tracking import usual_excitation
from uav_tracking_mpc.simulation.closed_loop import simulate
from uav_tracking_mpc.studies.executors import parallel_map
from uav_tracking_mpc.studies.identification.flight_record import (
    CHANNELS,
    FlightRecord,
    FlightWitness,
)
from uav_tracking_mpc.studies.identification.identification import CONFIDENCE, Estimates, identify
from uav_tracking_mpc.studies.study import Study

SCENARIO = "crosswind"
DURATION, EXCITED = 120.0, 60.0  # s of a flight, and of its end that are used
LAG, DEAD_TIME, GAIN = (0.05, 1.0), (0.0, 0.3), (0.8, 1.25)  # s, s, -: drawn from
TOLD = 2.0  # -, greatest factor by which lag and dead time are given wrong
# s, -: how near an estimate must come, also as a share of the truth.
NEAR = {"total": (0.03, 0.05), "lag": (0.06, 0.15), "dead_time": (0.06, 0.15)}
# m/s, rad, m/s: noise of the sensors
NOISE = {"velocity_noise": 0.3, "attitude_noise": math.radians(0.5), "airspeed_noise": 0.3}


Row = dict[str, dict[str, float]]  # of a channel, by the names of Estimates: truth and estimate


def drawn(
    config: str, overrides: tuple[str, ...], seed: int
) -> tuple[Configuration, dict[str, NDArray[np.float64]]]:
    """The configuration of a flight with what a seed draws; what is to be found, by name."""
    random = np.random.default_rng(seed)
    shortest, longest = np.log(LAG).tolist()
    lag = np.exp(random.uniform(shortest, longest, 3))
    dead_time, gain = random.uniform(*DEAD_TIME, 3), random.uniform(*GAIN, 3)
    told = np.exp(random.uniform(-math.log(TOLD), math.log(TOLD), (2, 3)))
    configuration = load_configuration(config, overrides, SCENARIO)
    true: dict[str, Any] = {
        "rate_lag": lag.tolist(),
        "dead_time": dead_time.tolist(),
        "command_gain": gain.tolist(),
        "seed": seed,
        **NOISE,
    }
    told_lag, told_dead_time = (told * (lag, dead_time)).tolist()
    signal = usual_excitation(configuration.controller.airspeed)
    believed = {"rate_lag": told_lag, "dead_time": told_dead_time, "excitation": signal}
    drawn_configuration = replace(
        configuration,
        simulator=changed(configuration.simulator, true),
        controller=changed(configuration.controller, believed),
        mission=replace(configuration.mission, duration=DURATION),
    )
    truth = {"lag": lag, "dead_time": dead_time, "total": lag + dead_time, "gain": gain}
    return drawn_configuration, truth


def fly(config: str, overrides: tuple[str, ...], seed: int) -> dict[str, Row]:
    """Fly and identify: a row for each channel."""
    configuration, truth = drawn(config, overrides, seed)
    witness = FlightWitness()
    simulate(configuration, witness=witness)
    found = identify(_used(witness.record()).channels())
    return {
        channel.name: {
            figure: {"truth": float(truth[figure][index]), **estimate._asdict()}
            for figure, estimate in channel.estimates._asdict().items()
        }
        for index, channel in enumerate(found)
    }


def _used(record: FlightRecord) -> FlightRecord:
    """What of a record is used: no rates, and nothing measured before the excitation."""
    assert record.airspeed is not None
    states = (record.heading, record.path_angle, record.airspeed)
    end = float(record.heading.time[-1])
    return FlightRecord(record.demand, *(each.within(end - EXCITED, end) for each in states))


def validate(
    config: str,
    overrides: Sequence[str] = (),
    count: int = 40,
    seed: int = 0,
    workers: int | None = None,
) -> Study:
    """Fly, identify and count.

    Args:
        config: Name or file of the configuration.
        overrides: ``SECTION.PARAMETER=VALUE`` each.
        count: How many flights.
        seed: Of the first; the others follow.
        workers: Processes; one for each core by default.

    Returns:
        Its content: ``channels.<name>.near`` and ``.covered``: share of the flights in which an
        estimate came near enough and in which its interval held the truth, by name of the figure;
        ``.errors``: of each flight.
    """
    flights = [(config, tuple(overrides), seed + index) for index in range(count)]
    rows = parallel_map(fly, flights, workers, "flights", least=1)
    channels = {name: _counted([row[name] for row in rows]) for name in CHANNELS}
    content = {
        "config": config,
        "flights": len(rows),
        "seed": seed,
        "confidence": CONFIDENCE,
        "channels": channels,
    }
    near = [f"{_words(name)} close [%]" for name in NEAR]
    covered = [f"{_words(name)} covered [%]" for name in Estimates._fields]
    cells = [
        [name, *(f"{100 * hit:.1f}" for hit in (*c["near"].values(), *c["covered"].values()))]
        for name, c in channels.items()
    ]
    bounds = ", ".join(
        f"{_words(name)} within {least:g} s or {share:.0%} of the truth"
        for name, (least, share) in NEAR.items()
    )
    table = Table(
        ["channel", *near, *covered],
        cells,
        numeric=(*near, *covered),
        title=f"{len(rows)} flights, {EXCITED:g} s of each",
        caption=f"close: {bounds}; covered: the interval of {CONFIDENCE:.0%} holds the truth.",
    )
    left = f"{len(rows)} of {count} flights were flown" if len(rows) < count else ""
    return Study("validation", content, [table], tables={"identification": table}, left=left)


def _words(name: str) -> str:
    return {"total": "sum"}.get(name, name.replace("_", " "))


def _counted(rows: Sequence[Row]) -> dict[str, Any]:
    def near(found: dict[str, float], least: float, share: float) -> bool:
        return abs(found["value"] - found["truth"]) <= max(least, share * found["truth"])

    return {
        "near": {name: _share(near(row[name], *how) for row in rows) for name, how in NEAR.items()},
        "covered": {
            name: _share(
                row[name]["lower"] <= row[name]["truth"] <= row[name]["upper"] for row in rows
            )
            for name in Estimates._fields
        },
        "errors": rows,
    }


def _share(hits: Iterable[bool]) -> float:
    return float(np.mean(list(hits)))
