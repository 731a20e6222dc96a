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

"""Fly a campaign: what each flight meets, its row of results, and all of them kept as they finish.

Every key is drawn from a stream of its own, seeded with the campaign's seed, the number of the draw
and the key: neither the number of processes nor another key changes what a flight meets. All
combinations of swept values meet the same draws, and so do all laws. Results are on disk as a file
for each batch, at the end as one Parquet file of all.
"""

from __future__ import annotations

import bisect
import io
import math
import shutil
import threading
import time
import zlib
from collections.abc import Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from itertools import accumulate
from pathlib import Path
from typing import Any

import numpy as np

from uav_tracking_mpc.control.guidance import formulation_of
from uav_tracking_mpc.formulation.formulation import Formulation
from uav_tracking_mpc.parameters.specification import ParameterError, refuse_fixed
from uav_tracking_mpc.report.atomic_write import write_atomically
from uav_tracking_mpc.settings.configuration import Configuration, Sections, configuration_of
from uav_tracking_mpc.settings.tracking import PREDICTIVE, TrackingParameters
from uav_tracking_mpc.simulation.closed_loop import simulate
from uav_tracking_mpc.simulation.flight_log import FlightLog
from uav_tracking_mpc.studies.campaign.campaign_file import NO, ONE, RAISED, Campaign, Group
from uav_tracking_mpc.studies.campaign.uncertain_inputs import read, write
from uav_tracking_mpc.studies.comparison.measures import measures
from uav_tracking_mpc.studies.comparison.scenarios import law_label, law_labels
from uav_tracking_mpc.studies.executors import Executor, tracked


@dataclass(frozen=True)
class PlannedFlight:
    """What a flight meets.

    Attributes:
        number: Of the flight.
        group: Name of its group.
        error: Names of the errors drawn, joined by ``+``; empty for none.
        values: Of all inputs that may differ between flights, by key.
        sections: The parameters, without the law.
    """

    number: int
    group: str
    error: str
    values: dict[str, Any]
    sections: Sections

    def configuration(self, law: str) -> Configuration:
        """Parameters of the flight by a law, as a name or ``path.py:Class``."""
        sections = {name: dict(values) for name, values in self.sections.items()}
        sections["nmpc_controller"]["law"] = law
        return configuration_of(flight_name(self.number, law), sections)


def flight_name(number: int, law: str) -> str:
    """Name of a flight by a law, of its file too."""
    return f"flight_{number:06d}_{law.rsplit(':', 1)[-1]}"


def planned(campaign: Campaign, number: int) -> PlannedFlight:
    """What a flight meets; its number is from 0 to ``campaign.total - 1``."""
    point, draw = divmod(number, campaign.flights)
    values = {
        key: each.draw(_stream(campaign, draw, key))
        for key, each in campaign.draw.items()
        if key not in campaign.swept
    }
    for key, swept in campaign.swept.items():
        point, index = divmod(point, len(swept))
        values[key] = swept[index]
    sections: Sections = {name: dict(them) for name, them in campaign.base.sections.items()}
    gusts, target = np.random.SeedSequence([campaign.seed, draw]).generate_state(2).tolist()
    sections["uav_simulator"]["seed"] = gusts >> 1  # the parameter takes 31 bits
    sections["target_publisher"]["seed"] = target >> 1
    write(sections, values)
    group, names = _group_of(campaign, draw)
    mistaken: dict[str, Any] = {}
    for name in names:
        for key, each in campaign.errors[name].items():
            neutral = mistaken[key] if key in mistaken else read(sections, key)
            random = _stream(campaign, draw, f"{name}/{key}")
            mistaken[key] = each.draw_within(random, neutral, group.range)
    write(sections, mistaken)
    effective = {
        key: mistaken[key] if key in mistaken else values.get(key, read(sections, key))
        for key in campaign.inputs
    }
    return PlannedFlight(number, group.name, "+".join(names), effective, sections)


def check_flights(campaign: Campaign, numbers: Iterable[int]) -> None:
    """Whether flights can be flown as they were drawn.

    Raises:
        ParameterError: One cannot; the message says which.
    """
    for number in numbers:
        try:
            flown = planned(campaign, number).configuration(campaign.laws[0])
        except ParameterError as error:
            raise ParameterError(f"campaign {campaign.name}, flight {number}: {error}") from error
        after, duration = campaign.settled_after, flown.mission.duration
        if after is not None and after >= duration:
            raise ParameterError(
                f"campaign {campaign.name}: 'settled_after' is {after:g} s, flight {number} ends "
                f"after {duration:g} s"
            )


def _stream(campaign: Campaign, draw: int, key: str) -> np.random.Generator:
    return np.random.default_rng([campaign.seed, draw, zlib.crc32(key.encode())])


def _group_of(campaign: Campaign, draw: int) -> tuple[Group, list[str]]:
    """Group of a draw and names of its errors: groups follow one another, as do single errors."""
    shares = accumulate(group.share for group in campaign.groups)
    begins = [0, *(round(share * campaign.flights) for share in shares)][:-1]
    place = bisect.bisect_right(begins, draw) - 1
    group, names = campaign.groups[place], list(campaign.errors)
    if group.errors == ONE:
        rank = draw - begins[place]
        names = [names[rank % len(names)]]
    return group, [] if group.errors == NO else names


Task = tuple[int, str]  # number of a flight, and the law
Row = dict[str, Any]
_of_thread = threading.local()  # a solver has one workspace: threads must not share it
_compiling = threading.Lock()
# Columns of measures that a flight gives.
MEASURED = (
    "range_rms_m", "range_mean_m", "worst_m", "altitude_rms_m", "airspeed_rms_mps",
    "bank_rate_rms_dps",
)  # fmt: skip


def fly_batch(campaign: Campaign, tasks: Sequence[Task]) -> list[Row]:
    """Fly some flights, one after the other, on one compiled solver: a row for each."""
    return [fly_one(campaign, *task) for task in tasks]


def fly_one(campaign: Campaign, number: int, law: str) -> Row:
    """Fly a flight; one that raises an error has failed by it.

    Args:
        campaign: That it belongs to.
        number: Of the flight.
        law: Name of the law, or ``path.py:Class``.
    """
    flight = planned(campaign, number)
    try:
        configuration = flight.configuration(law)
        formulation = shared_formulation(configuration.controller)
        log = simulate(configuration, formulation=formulation)
        outcome = _outcome(campaign, log, configuration.controller)
    except Exception as error:  # whatever it is, it is this flight's failure and no other's
        _of_thread.kept = None  # it may be left half changed
        outcome = {"failed": True, "reasons": RAISED, "error": f"{type(error).__name__}: {error}"}
    words = campaign.words
    return {
        "flight": number,
        "law": law_label(law),
        "group": flight.group,
        "mistake": flight.error,
        **{key: str(x) if key in words else float(x) for key, x in flight.values.items()},
        **outcome,
    }


def _outcome(campaign: Campaign, log: FlightLog, parameters: TrackingParameters) -> Row:
    """What came of a flight."""
    after, failure = campaign.settled_after, campaign.failure
    flown = measures(log, parameters, 0.5 * log.duration if after is None else after)
    range_error = log.error[:, 0]
    reasons = failure.failures(log, range_error, parameters)
    settled = failure.settled_at(log.time, range_error)
    worst = math.nan
    if settled is not None:
        worst = float(np.max(np.abs(range_error[log.time >= settled])))
    return {
        "failed": bool(reasons),
        "reasons": ",".join(reasons),
        "error": "",
        "settled_s": settled,
        "worst_settled_m": worst if math.isfinite(worst) else None,
        **{name: getattr(flown, name) for name in MEASURED},
        "envelope_violations": flown.envelope_violations,
        "solves_failed": log.failures,
        "off_plan": log.commands.plan_reused + log.commands.failsafe,
    }


def shared_formulation(parameters: TrackingParameters) -> Formulation | None:
    """The formulation that this thread's flights share, if nothing fixed differs; else a new one.

    None where a guidance law is flown.
    """
    kept: tuple[TrackingParameters, Formulation] | None = getattr(_of_thread, "kept", None)
    if kept is not None:
        before, formulation = kept
        with suppress(ParameterError):  # another problem, or a guidance law
            refuse_fixed(before, parameters)
            formulation.check(parameters)
            return formulation
    with _compiling:
        made = formulation_of(parameters)
    if made is not None:
        _of_thread.kept = parameters, made
    return made


FILE = "flights.parquet"
IDENTITY = b"campaign"  # under which a file's metadata hold the campaign's digest


class FlightStore:
    """The folder of a campaign.

    Args:
        campaign: Whose results it holds.
        folder: Made if it is not there.

    Attributes:
        file: Where all results are at the end.
        rows: What it holds, by flight and law.

    Raises:
        ParameterError: The folder holds another campaign.
        OSError: It cannot be made or read.
    """

    def __init__(self, campaign: Campaign, folder: Path) -> None:
        self.file = folder / FILE
        self.rows: dict[Task, Row] = {}
        self._campaign, self._parts = campaign, folder / "batches"
        self._schema = _schema(campaign)
        folder.mkdir(parents=True, exist_ok=True)
        for file in [*sorted(self._parts.glob("*.parquet")), *([self.file] * self.file.exists())]:
            self._add(self._read(file))

    def _read(self, file: Path) -> list[Row]:
        from pyarrow import ArrowException, parquet

        try:
            table = parquet.ParquetFile(file).read()
        except ArrowException as error:
            raise ParameterError(f"{file} is no Parquet file of a campaign: {error}") from error
        if (table.schema.metadata or {}).get(IDENTITY) != self._schema.metadata[IDENTITY]:
            raise ParameterError(
                f"{file} holds flights of another campaign or version: take another --output, or "
                "remove them"
            )
        return list(table.to_pylist())

    def _add(self, rows: Sequence[Row]) -> None:
        self.rows |= {(row["flight"], row["law"]): row for row in rows}

    def left(self) -> list[Task]:
        """Flights that have not been flown, with their laws, in order."""
        return [
            (number, law)
            for number in range(self._campaign.total)
            for law in self._campaign.laws
            if (number, law_label(law)) not in self.rows
        ]

    def keep(self, rows: Sequence[Row]) -> None:
        """Keep a batch of at least one flight, at once and whole."""
        self._parts.mkdir(exist_ok=True)
        name = f"{rows[0]['flight']:09d}_{rows[0]['law']}.parquet"
        write_atomically(self._parts / name, self._content(rows))
        self._add(rows)

    def finish(self) -> list[Row]:
        """Write one file of all and remove the batches, and what was worst of fewer flights.

        Returns:
            All rows, by number and law.
        """
        laws = law_labels(self._campaign.laws)
        rows = sorted(self.rows.values(), key=lambda row: (row["flight"], laws.index(row["law"])))
        if self._parts.exists() or not self.file.exists():
            write_atomically(self.file, self._content(rows))
            shutil.rmtree(self._parts, ignore_errors=True)
        for old in self.file.parent.glob("worst/flight_*.yaml"):
            old.unlink()
        return rows

    def _content(self, rows: Sequence[Row]) -> bytes:
        import pyarrow
        from pyarrow import parquet

        buffer = io.BytesIO()
        parquet.write_table(pyarrow.Table.from_pylist(list(rows), schema=self._schema), buffer)
        return buffer.getvalue()


def _schema(campaign: Campaign) -> Any:
    """Columns, for pyarrow: flight, law and group; what was drawn; what came of it."""
    import pyarrow

    text, number, count = pyarrow.string(), pyarrow.float64(), pyarrow.int64()
    words = campaign.words
    kinds = {
        "flight": count,
        **dict.fromkeys(("law", "group", "mistake"), text),
        **{key: text if key in words else number for key in campaign.inputs},
        "failed": pyarrow.bool_(),
        **dict.fromkeys(("reasons", "error"), text),
        **dict.fromkeys(("settled_s", "worst_settled_m", *MEASURED), number),
        **dict.fromkeys(("envelope_violations", "solves_failed", "off_plan"), count),
    }
    return pyarrow.schema(list(kinds.items()), {IDENTITY: campaign.identity.encode()})


@dataclass(frozen=True)
class CampaignResults:
    """What came of a campaign.

    Attributes:
        campaign: What was flown.
        rows: Of all flights, by number and law.
        file: Parquet file that holds them.
        flown: How many flights were flown now; the others were there.
        left: How many are to be flown yet, as the user interrupted.
        seconds: Wall time of these in [s].
        workers: That flew them.
    """

    campaign: Campaign
    rows: list[Row]
    file: Path
    flown: int
    left: int
    seconds: float
    workers: int

    @property
    def laws(self) -> list[str]:
        """Labels of the laws."""
        return law_labels(self.campaign.laws)


def run_campaign(
    campaign: Campaign, executor: Executor, folder: Path, show: bool = True
) -> CampaignResults:
    """Fly what has not been flown.

    Args:
        campaign: What to fly.
        executor: Where it flies.
        folder: For the results; what it holds of this campaign is not flown again.
        show: Progress bar on stderr.

    Raises:
        ParameterError: A flight cannot be flown as it was drawn, two laws have one name, or the
            folder holds another campaign.
        WorkerError: Workers were lost; what was flown is kept.
        KeyboardInterrupt: The user interrupted before anything was flown.
    """
    law_labels(campaign.laws)
    for law in campaign.laws:
        planned(campaign, 0).configuration(law)
    store = FlightStore(campaign, folder)
    tasks = store.left()
    begin = time.perf_counter()
    if tasks:
        check_flights(campaign, tracked(range(campaign.total), "checking flights", show=show))
        if PREDICTIVE in campaign.laws:  # compile here, once, and not in every process
            first = planned(campaign, tasks[0][0]).configuration(PREDICTIVE)
            shared_formulation(first.controller)
        # Small campaigns too have a batch for every worker.
        size = max(1, min(executor.batch, len(tasks) // (4 * executor.workers)))
        batches = [tasks[begin : begin + size] for begin in range(0, len(tasks), size)]
        flown = executor.run(fly_batch, campaign, batches)
        try:
            for rows in tracked(flown, "flights", len(batches), show):
                store.keep(rows)
        except KeyboardInterrupt:
            if not store.rows:
                raise
    seconds, left = time.perf_counter() - begin, len(store.left())
    rows, flights = store.finish(), len(tasks) - left
    return CampaignResults(campaign, rows, store.file, flights, left, seconds, executor.workers)
