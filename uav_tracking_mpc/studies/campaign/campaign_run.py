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

import io
import math
import shutil
import threading
import time
import zlib
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TimeRemainingColumn

from uav_tracking_mpc.control.guidance import formulation_of
from uav_tracking_mpc.formulation.formulation import Formulation
from uav_tracking_mpc.parameters.specification import ParameterError, refuse_fixed
from uav_tracking_mpc.report.atomic_write import write_atomically
from uav_tracking_mpc.settings.configuration import Configuration, Sections, configuration_of
from uav_tracking_mpc.settings.tracking import PREDICTIVE, TrackingParameters
from uav_tracking_mpc.simulation.closed_loop import simulate
from uav_tracking_mpc.simulation.flight_log import FlightLog
from uav_tracking_mpc.studies.campaign.campaign_file import ALL, ONE, RAISED, Campaign, Group
from uav_tracking_mpc.studies.campaign.uncertain_inputs import read, write
from uav_tracking_mpc.studies.comparison.measures import measures
from uav_tracking_mpc.studies.comparison.scenarios import law_label, law_labels
from uav_tracking_mpc.studies.executors import Executor, LocalExecutor

if TYPE_CHECKING:
    import pyarrow


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
        if not each.swept
    }
    for key, swept in campaign.swept.items():
        point, index = divmod(point, len(swept))
        values[key] = swept[index]
    sections: Sections = {name: dict(them) for name, them in campaign.base.sections.items()}
    gusts, target = np.random.SeedSequence([campaign.seed, draw]).generate_state(2).tolist()
    sections["uav_simulator"]["seed"] = gusts >> 1  # the parameter takes 31 bits
    sections["target_publisher"]["seed"] = target >> 1
    write(sections, values)
    group, rank = _group_of(campaign, draw)
    names = _errors_of(campaign, group, rank)
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


def check_flights(campaign: Campaign, numbers: Sequence[int]) -> None:
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


def _group_of(campaign: Campaign, draw: int) -> tuple[Group, int]:
    """Group of a draw, and its rank in it: groups follow one another."""
    begin, share = 0, 0.0
    for group in campaign.groups:
        share += group.share
        end = round(share * campaign.flights)
        if draw < end:
            return group, draw - begin
        begin = end
    return campaign.groups[-1], draw - begin


def _errors_of(campaign: Campaign, group: Group, rank: int) -> list[str]:
    names = list(campaign.errors)
    if group.errors == ONE:
        return [names[rank % len(names)]]
    return names if group.errors == ALL else []


Task = tuple[int, str]  # number of a flight, and the law
Row = dict[str, Any]
_of_thread = threading.local()  # a solver has one workspace: threads must not share it
_compiling = threading.Lock()
# Columns of numbers and of counts that a flight gives.
FIGURES = (
    "settled_s", "worst_settled_m", "range_rms_m", "range_mean_m", "worst_m", "altitude_rms_m",
    "airspeed_rms_mps", "bank_rate_rms_dps",
)  # fmt: skip
COUNTS = ("envelope_violations", "solves_failed", "off_plan")


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
    inputs = {k: str(x) if k in words else float(x) for k, x in flight.values.items()}
    return {
        "flight": number,
        "law": law_label(law),
        "group": flight.group,
        "mistake": flight.error,
        **inputs,
        **outcome,
    }


def _outcome(campaign: Campaign, log: FlightLog, parameters: TrackingParameters) -> Row:
    """What came of a flight."""
    after, failure = campaign.settled_after, campaign.failure
    flown = measures(log, parameters, 0.5 * log.duration if after is None else after)
    range_error = log.error[:, 0]
    reasons = failure.failures(log, range_error, parameters)
    settled = failure.settled_at(log.time, range_error)
    worst = float(np.max(np.abs(range_error[log.time >= settled]))) if settled else math.nan
    own = {
        "settled_s": settled,
        "worst_settled_m": worst if math.isfinite(worst) else None,
        "solves_failed": log.failures,
        "off_plan": log.commands.plan_reused + log.commands.failsafe,
    }
    columns = {
        name: own[name] if name in own else getattr(flown, name) for name in (*FIGURES, *COUNTS)
    }
    return {"failed": bool(reasons), "reasons": ",".join(reasons), "error": "", **columns}


def shared_formulation(parameters: TrackingParameters) -> Formulation | None:
    """The formulation that this thread's flights share, if nothing fixed differs; else a new one.

    None where a guidance law is flown.
    """
    kept: tuple[TrackingParameters, Formulation] | None = getattr(_of_thread, "kept", None)
    if kept is not None:
        before, formulation = kept
        try:
            refuse_fixed(before, parameters)
            formulation.check(parameters)
        except ParameterError:
            pass  # another problem, or a guidance law
        else:
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

    Raises:
        ParameterError: The folder holds another campaign.
        OSError: It cannot be made or read.
    """

    def __init__(self, campaign: Campaign, folder: Path) -> None:
        self.file = folder / FILE
        self._campaign, self._parts = campaign, folder / "batches"
        self._schema = _schema(campaign)
        folder.mkdir(parents=True, exist_ok=True)
        self._rows: dict[Task, Row] = {}
        files = [*sorted(self._parts.glob("*.parquet")), *([self.file] * self.file.exists())]
        for file in files:
            self._read(file)

    def _read(self, file: Path) -> None:
        from pyarrow import ArrowException, parquet

        try:
            table = parquet.ParquetFile(file).read()
        except ArrowException as error:
            raise ParameterError(f"{file} is no Parquet file of a campaign: {error}") from error
        if table.schema.metadata is None or table.schema.metadata.get(IDENTITY) != self._identity:
            raise ParameterError(
                f"{file} holds flights of another campaign or version: take another --output, or "
                "remove them"
            )
        for row in table.to_pylist():
            self._rows[row["flight"], row["law"]] = row

    @property
    def _identity(self) -> bytes:
        return self._campaign.identity.encode()

    @property
    def empty(self) -> bool:
        """Whether it holds no flight."""
        return not self._rows

    def left(self) -> list[Task]:
        """Flights that have not been flown, with their laws, in order."""
        return [
            (number, law)
            for number in range(self._campaign.total)
            for law in self._campaign.laws
            if (number, law_label(law)) not in self._rows
        ]

    def keep(self, rows: Sequence[Row]) -> None:
        """Keep a batch of at least one flight, at once and whole."""
        self._parts.mkdir(exist_ok=True)
        first = rows[0]
        write_atomically(
            self._parts / f"{first['flight']:09d}_{first['law']}.parquet", self._content(rows)
        )
        self._rows.update({(row["flight"], row["law"]): row for row in rows})

    def finish(self) -> list[Row]:
        """Write one file of all and remove the batches, and what was worst of fewer flights.

        Returns:
            All rows, by number and law.
        """
        laws = law_labels(self._campaign.laws)
        rows = sorted(self._rows.values(), key=lambda row: (row["flight"], laws.index(row["law"])))
        if self._parts.exists() or not self.file.exists():
            write_atomically(self.file, self._content(rows))
            shutil.rmtree(self._parts, ignore_errors=True)
        for old in self.file.parent.glob("worst/flight_*.yaml"):
            old.unlink()
        return rows

    def _content(self, rows: Sequence[Row]) -> bytes:
        import pyarrow
        from pyarrow import parquet

        schema = self._schema.with_metadata({IDENTITY: self._identity})
        table = pyarrow.Table.from_pylist(list(rows), schema=schema)
        buffer = io.BytesIO()
        parquet.write_table(table, buffer)
        return buffer.getvalue()


def _schema(campaign: Campaign) -> pyarrow.Schema:
    """Columns: flight, law and group; what was drawn; what came of it."""
    import pyarrow

    text, number, count = pyarrow.string(), pyarrow.float64(), pyarrow.int64()
    words = campaign.words
    kinds = {
        "flight": count,
        **dict.fromkeys(("law", "group", "mistake"), text),
        **{key: text if key in words else number for key in campaign.inputs},
        "failed": pyarrow.bool_(),
        **dict.fromkeys(("reasons", "error"), text),
        **dict.fromkeys(FIGURES, number),
        **dict.fromkeys(COUNTS, count),
    }
    return pyarrow.schema(list(kinds.items()))


CHECKED = 100  # flights at a time
CHECKED_HERE = 2000  # flights, some seconds; more of them are checked where they will be flown


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
        columns = ("{task.description}", BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
        console = Console(stderr=True)
        with Progress(*columns, console=console, transient=True, disable=not show) as bar:
            _check(campaign, executor, bar)
            if PREDICTIVE in campaign.laws:  # compile here, once, and not in every process
                first = planned(campaign, tasks[0][0]).configuration(PREDICTIVE)
                shared_formulation(first.controller)
            try:
                _fly(campaign, executor, store, tasks, bar)
            except KeyboardInterrupt:
                if store.empty:
                    raise
    seconds, left = time.perf_counter() - begin, len(store.left())
    flown = len(tasks) - left
    return CampaignResults(
        campaign, store.finish(), store.file, flown, left, seconds, executor.workers
    )


def _check(campaign: Campaign, executor: Executor, bar: Progress) -> None:
    """Check all flights before the first is flown."""
    starts = range(0, campaign.total, CHECKED)
    batches = [range(begin, min(begin + CHECKED, campaign.total)) for begin in starts]
    here = LocalExecutor(1) if campaign.total <= CHECKED_HERE else executor
    task = bar.add_task("checking flights", total=len(batches))
    for _ in here.run(check_flights, campaign, batches):  # raises where a flight is refused
        bar.advance(task)
    bar.remove_task(task)


def _fly(
    campaign: Campaign, executor: Executor, store: FlightStore, tasks: list[Task], bar: Progress
) -> None:
    # Small campaigns too have a batch for every worker.
    size = max(1, min(executor.batch, len(tasks) // (4 * executor.workers)))
    rest = iter(tasks)
    batches = list(iter(lambda: list(islice(rest, size)), []))
    total = campaign.total * len(campaign.laws)
    task = bar.add_task("flights", total=total, completed=total - len(tasks))
    failed = 0
    for rows in executor.run(fly_batch, campaign, batches):
        store.keep(rows)
        failed += sum(row["failed"] for row in rows)
        bar.update(task, advance=len(rows), description=f"flights, {failed} failed")
