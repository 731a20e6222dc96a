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

"""Where batches are flown: in processes of this machine, or on a Dask cluster."""

from __future__ import annotations

import multiprocessing
import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from typing import Protocol, TypeVar

from uav_tracking_mpc.studies.campaign.campaign_file import Campaign
from uav_tracking_mpc.studies.parallel import end_with_parent

P = TypeVar("P")
R = TypeVar("R")
Work = Callable[[Campaign, P], R]

LOCAL_BATCH = 4  # flights: no more is lost when this process is killed
CLUSTER_BATCH = 25  # flights: a minute of work, beside which a message is nothing

WORKERS_WITHIN = 60  # s, for a cluster that has just been started


class CampaignError(RuntimeError):
    """The flights could not all be flown; what was flown is kept."""


class Executor(Protocol):
    """Works through batches.

    Attributes:
        workers: How many fly at a time.
        batch: Flights of a batch.
    """

    workers: int
    batch: int

    def run(self, work: Work[P, R], campaign: Campaign, batches: Sequence[P]) -> Iterator[R]:
        """What came of each batch, as they finish.

        Args:
            work: At module level, so that processes can find it.
            campaign: Its first argument.
            batches: Its second.

        Raises:
            CampaignError: A worker was lost.
        """
        ...

    def close(self) -> None:
        """Let go of whatever works."""
        ...


class LocalExecutor:
    """Processes of this machine; a single one is this process.

    Args:
        workers: How many; one for each core by default.
    """

    batch = LOCAL_BATCH

    def __init__(self, workers: int | None = None) -> None:
        self.workers = workers or len(os.sched_getaffinity(0))

    def run(self, work: Work[P, R], campaign: Campaign, batches: Sequence[P]) -> Iterator[R]:
        """See :meth:`Executor.run`."""
        workers = min(self.workers, len(batches))
        if workers < 2:
            for batch in batches:
                yield work(campaign, batch)
            return
        # spawn: a fork would copy whatever threads the caller has running.
        context = multiprocessing.get_context("spawn")
        pool = ProcessPoolExecutor(workers, mp_context=context, initializer=end_with_parent)
        try:
            pending = [pool.submit(work, campaign, batch) for batch in batches]
            for future in as_completed(pending):
                yield future.result()
        except BrokenProcessPool as error:
            raise CampaignError(
                "a worker process ended abruptly (was there too little memory?); the same command "
                "goes on with what is left"
            ) from error
        finally:
            pool.shutdown(wait=True, cancel_futures=True)

    def close(self) -> None:
        """See :meth:`Executor.close`; processes end with each run."""


class DaskExecutor:
    """Workers of a Dask cluster, on which this package is installed.

    Args:
        address: Of the scheduler, such as ``tcp://host:8786``.

    Raises:
        CampaignError: Nobody answers there.
    """

    batch = CLUSTER_BATCH

    def __init__(self, address: str) -> None:
        from distributed import Client

        try:
            self._client = Client(address, set_as_default=False)
        except (OSError, ValueError) as error:
            raise CampaignError(f"no Dask scheduler answers at {address}: {error}") from error
        try:
            self._client.wait_for_workers(1, timeout=WORKERS_WITHIN)
        except TimeoutError as error:
            self.close()
            raise CampaignError(f"the Dask scheduler at {address} has no workers") from error
        self.workers = sum(self._client.nthreads().values())

    def run(self, work: Work[P, R], campaign: Campaign, batches: Sequence[P]) -> Iterator[R]:
        """See :meth:`Executor.run`."""
        from distributed import as_completed as completed
        from distributed.scheduler import KilledWorker

        client = self._client
        # A task and not scattered data, which would be lost with the workers that hold it.
        shared = client.submit(_itself, campaign, pure=False)
        # A batch whose worker dies is flown again by another: nothing of it has come back.
        pending = [client.submit(work, shared, batch, pure=False) for batch in batches]
        try:
            for future in completed(pending, loop=client.loop):
                yield future.result()
                future.release()
        except KilledWorker as error:
            raise CampaignError(f"{error}; the same command goes on with the rest") from error

    def close(self) -> None:
        """See :meth:`Executor.close`; the cluster stays."""
        self._client.close()


def _itself(campaign: Campaign) -> Campaign:
    return campaign
