"""Fly a campaign: what is left of it, in batches, kept as they finish."""

from __future__ import annotations

import time
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

from uav_tracking_mpc.parameters.specification import ParameterError
from uav_tracking_mpc.settings.tracking import PREDICTIVE
from uav_tracking_mpc.studies.campaign.campaign_file import Campaign
from uav_tracking_mpc.studies.campaign.executors import Executor
from uav_tracking_mpc.studies.campaign.flight_plan import check_flights, planned
from uav_tracking_mpc.studies.campaign.flight_store import FlightStore
from uav_tracking_mpc.studies.campaign.one_flight import Row, Task, fly_batch, shared_formulation
from uav_tracking_mpc.studies.comparison.law_names import law_label

CHECKED_HERE = 2000  # flights, some seconds


@dataclass(frozen=True)
class CampaignResults:
    """What came of a campaign.

    Attributes:
        campaign: What was flown.
        rows: Of all flights, by number and law.
        file: Parquet file that holds them.
        flown: How many flights were flown now; the others were there.
        seconds: Wall time of these in [s].
        workers: That flew them.
    """

    campaign: Campaign
    rows: list[Row]
    file: Path
    flown: int
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
        _check(campaign, executor)
        if PREDICTIVE in campaign.laws:  # compile here, once, and not in every process
            shared_formulation(planned(campaign, tasks[0][0]).configuration(PREDICTIVE).controller)
        _fly(campaign, executor, store, tasks, show)
    seconds = time.perf_counter() - begin
    return CampaignResults(
        campaign, store.finish(), store.file, len(tasks), seconds, executor.workers
    )


def _check(campaign: Campaign, executor: Executor) -> None:
    """Check all flights before the first is flown: many of them where they will be flown."""
    if campaign.total <= CHECKED_HERE:
        check_flights(campaign, range(campaign.total))
        return
    starts = range(0, campaign.total, CHECKED_HERE)
    batches = [range(begin, min(begin + CHECKED_HERE, campaign.total)) for begin in starts]
    for _ in executor.run(check_flights, campaign, batches):
        pass  # raises where a flight is refused


def _fly(
    campaign: Campaign, executor: Executor, store: FlightStore, tasks: list[Task], show: bool
) -> None:
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TimeRemainingColumn

    # Small campaigns too have a batch for every worker.
    size = max(1, min(executor.batch, len(tasks) // (4 * executor.workers)))
    rest = iter(tasks)
    batches = list(iter(lambda: list(islice(rest, size)), []))
    total = campaign.total * len(campaign.laws)
    columns = ("{task.description}", BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True, disable=not show) as bar:
        task = bar.add_task("flights", total=total, completed=total - len(tasks))
        failed = 0
        for rows in executor.run(fly_batch, campaign, batches):
            store.keep(rows)
            failed += sum(row["failed"] for row in rows)
            bar.update(task, advance=len(rows), description=f"flights, {failed} failed")
