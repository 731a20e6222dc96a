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

"""Fly a campaign: what is left of it, in batches, kept as they finish."""

from __future__ import annotations

import time
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TimeRemainingColumn

from uav_tracking_mpc.parameters.specification import ParameterError
from uav_tracking_mpc.settings.tracking import PREDICTIVE
from uav_tracking_mpc.studies.campaign.campaign_file import Campaign
from uav_tracking_mpc.studies.campaign.executors import Executor, LocalExecutor
from uav_tracking_mpc.studies.campaign.flight_plan import check_flights, planned
from uav_tracking_mpc.studies.campaign.flight_store import FlightStore
from uav_tracking_mpc.studies.campaign.one_flight import Row, Task, fly_batch, shared_formulation
from uav_tracking_mpc.studies.comparison.law_names import law_label

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
        CampaignError: Workers were lost; what was flown is kept.
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
