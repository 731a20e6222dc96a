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
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TimeRemainingColumn

from uav_tracking_mpc.control.guidance import formulation_of
from uav_tracking_mpc.formulation.formulation import Formulation
from uav_tracking_mpc.parameters.specification import ParameterError, refuse_fixed
from uav_tracking_mpc.report.atomic_write import write_atomically
from uav_tracking_mpc.settings.configuration import Configuration
from uav_tracking_mpc.settings.tracking import PREDICTIVE, TrackingParameters
from uav_tracking_mpc.simulation.closed_loop import simulate
from uav_tracking_mpc.simulation.flight_log import FlightLog
from uav_tracking_mpc.studies.campaign.campaign_file import Campaign
from uav_tracking_mpc.studies.campaign.criteria import RAISED, Criteria
from uav_tracking_mpc.studies.campaign.flight_plan import check_flights, planned
from uav_tracking_mpc.studies.comparison.measures import measures
from uav_tracking_mpc.studies.comparison.scenarios import law_label
from uav_tracking_mpc.studies.executors import Executor, LocalExecutor

if TYPE_CHECKING:
    import pyarrow


Task = tuple[int, str]  # number of a flight, and the law
Row = dict[str, Any]
_of_thread = threading.local()  # a solver has one workspace: threads must not share it
_compiling = threading.Lock()


def fly_batch(campaign: Campaign, tasks: Sequence[Task]) -> list[Row]:
    """Fly some flights, one after the other, on one compiled solver.

    Args:
        campaign: That they belong to.
        tasks: Which flights by which law.

    Returns:
        A row for each.
    """
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
        outcome = outcome_of(log, configuration, campaign.failure, campaign.settled_after)
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


def outcome_of(
    log: FlightLog, configuration: Configuration, failure: Criteria, settled_after: float | None
) -> Row:
    """What came of a flight.

    Args:
        log: Record of the flight.
        configuration: What was flown.
        failure: What counts as a failure.
        settled_after: Time in [s] from which on statistics count; None for half the flight.
    """
    parameters = configuration.controller
    after = 0.5 * log.duration if settled_after is None else settled_after
    flown, range_error = measures(log, parameters, after), log.error[:, 0]
    reasons = failure.failures(log, range_error, parameters)
    settled = failure.settled_at(log.time, range_error)
    return {
        "failed": bool(reasons),
        "reasons": ",".join(reasons),
        "error": "",
        "settled_s": settled,
        "worst_settled_m": _worst(range_error[log.time >= settled]) if settled else None,
        "range_rms_m": flown.range_rms_m,
        "range_mean_m": flown.range_mean_m,
        "worst_m": flown.worst_m,
        "altitude_rms_m": flown.altitude_rms_m,
        "airspeed_rms_mps": flown.airspeed_rms_mps,
        "bank_rate_rms_dps": flown.bank_rate_rms_dps,
        "envelope_violations": flown.envelope_violations,
        "solves_failed": log.failures,
        "off_plan": log.commands.plan_reused + log.commands.failsafe,
    }


def _worst(error: NDArray[np.float64]) -> float | None:
    worst = float(np.max(np.abs(error)))
    return worst if math.isfinite(worst) else None


def shared_formulation(parameters: TrackingParameters) -> Formulation | None:
    """The formulation that this thread's flights share, if nothing fixed differs; else a new one.

    Args:
        parameters: What is flown.

    Returns:
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
FIGURES = (
    "settled_s", "worst_settled_m", "range_rms_m", "range_mean_m", "worst_m", "altitude_rms_m",
    "airspeed_rms_mps", "bank_rate_rms_dps",
)  # fmt: skip


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
        """Keep a batch, at once and whole.

        Args:
            rows: Of its flights, at least one.

        Raises:
            OSError: The folder cannot be written to.
        """
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

        Raises:
            OSError: The folder cannot be written to.
        """
        laws = [law_label(law) for law in self._campaign.laws]
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

    words = campaign.words
    kinds: dict[str, Any] = {"flight": pyarrow.int64()}
    kinds |= {name: pyarrow.string() for name in ("law", "group", "mistake")}
    for key in campaign.inputs:
        kinds[key] = pyarrow.string() if key in words else pyarrow.float64()
    kinds |= {"failed": pyarrow.bool_(), "reasons": pyarrow.string(), "error": pyarrow.string()}
    kinds |= {name: pyarrow.float64() for name in FIGURES}
    counts = ("envelope_violations", "solves_failed", "off_plan")
    kinds |= {name: pyarrow.int64() for name in counts}
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
        return [law_label(law) for law in self.campaign.laws]


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
    labels = [law_label(law) for law in campaign.laws]
    if len(set(labels)) < len(labels):
        raise ParameterError(f"laws are {', '.join(labels)}, each must have a name of its own")
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
