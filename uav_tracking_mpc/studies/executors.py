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

"""Work in processes: those of this machine, or workers of a Dask cluster."""

from __future__ import annotations

import math
import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from contextlib import closing
from itertools import starmap
from typing import Any, TypeVar

from rich.console import Console
from rich.progress import track

S = TypeVar("S")
P = TypeVar("P")
R = TypeVar("R")

Pieces = Sequence[tuple[Any, ...]]  # arguments of each call; they must pickle

LOCAL_BATCH = 4  # flights: no more is lost when this process is killed
CLUSTER_BATCH = 25  # flights: a minute of work, beside which a message is nothing

WORKERS_WITHIN = 60  # s, for a cluster that has just been started


class WorkerError(RuntimeError):
    """Workers were lost or never there, so that not all was done."""


class LocalExecutor:
    """Processes of this machine; a single one is this process.

    Args:
        workers: How many; one for each core by default.

    Attributes:
        workers: How many work at a time.
        batch: Pieces of a batch, to go by.
    """

    batch = LOCAL_BATCH

    def __init__(self, workers: int | None = None) -> None:
        self.workers = workers or len(os.sched_getaffinity(0))

    def run(self, work: Callable[[S, P], R], shared: S, batches: Sequence[P]) -> Iterator[R]:
        """What came of each batch, as they finish.

        Args:
            work: At module level, so that processes can find it.
            shared: Its first argument.
            batches: Its second.

        Raises:
            WorkerError: A worker was lost.
        """
        return self.map(work, [(shared, batch) for batch in batches], as_completed)

    def map(
        self,
        work: Callable[..., R],
        pieces: Pieces,
        order: Callable[[list[Future[R]]], Iterable[Future[R]]] = iter,
    ) -> Generator[R, None, None]:
        """What came of each piece.

        Args:
            work: At module level, so that processes can find it.
            pieces: Its arguments.
            order: Of the results: by default that of the pieces.

        Raises:
            WorkerError: A worker was lost.
        """
        workers = min(self.workers, len(pieces))
        if workers < 2:
            yield from starmap(work, pieces)
            return
        # spawn: a fork would copy whatever threads the caller has running.
        context = multiprocessing.get_context("spawn")
        others = set(multiprocessing.active_children())
        pool = ProcessPoolExecutor(workers, mp_context=context, initializer=_end_with_parent)
        try:
            for future in order([pool.submit(work, *piece) for piece in pieces]):
                yield future.result()
        except BrokenProcessPool as error:
            raise WorkerError(
                "a worker process ended abruptly (was there too little memory?); of a campaign "
                "the same command goes on with what is left"
            ) from error
        except (KeyboardInterrupt, GeneratorExit):
            # What is under way is nobody's any more, and may take a minute.
            for worker in set(multiprocessing.active_children()) - others:
                worker.terminate()
            raise
        finally:
            pool.shutdown(wait=True, cancel_futures=True)

    def close(self) -> None:
        """Nothing to let go of: processes end with each run."""


def _end_with_parent() -> None:
    """In a worker: leave Ctrl-C to the parent, and end when it is killed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = multiprocessing.parent_process()
    assert parent is not None

    def watch() -> None:
        parent.join()
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()


def parallel_map(
    function: Callable[..., R],
    pieces: Pieces,
    workers: int | None = None,
    label: str = "",
    show: bool = True,
    least: float = math.inf,
) -> list[R]:
    """Call a function with every piece in processes of this machine.

    Args:
        function: At module level, so that processes can find it.
        pieces: Its arguments.
        workers: Processes; one for each core by default; 1 stays in this process.
        label: What the progress bar on stderr says.
        show: Whether to show it.
        least: How many results are of use where the user interrupts; none by default.

    Returns:
        Results in the order of the pieces; the first of them where the user interrupted.

    Raises:
        WorkerError: A worker was lost.
        KeyboardInterrupt: The user interrupted before enough was done.
    """
    done: list[R] = []
    try:
        with closing(LocalExecutor(workers).map(function, pieces)) as results:
            for result in tracked(results, label, len(pieces), show):
                done.append(result)
    except KeyboardInterrupt:
        if len(done) < least:
            raise
    return done


def tracked(
    results: Iterable[R], label: str, total: int | None = None, show: bool = True
) -> Iterable[R]:
    """Results as they come, with a progress bar on stderr.

    Args:
        results: To go through.
        label: What the bar says.
        total: How many there are; needed of what has no length.
        show: Whether to show it.
    """
    return track(results, label, total, console=Console(stderr=True), disable=not show)


class DaskExecutor:
    """Workers of a Dask cluster, on which this package is installed.

    Args:
        address: Of the scheduler, such as ``tcp://host:8786``.

    Raises:
        WorkerError: Nobody answers there.
    """

    batch = CLUSTER_BATCH

    def __init__(self, address: str) -> None:
        from distributed import Client

        try:
            self._client = Client(address, set_as_default=False)
        except (OSError, ValueError) as error:
            raise WorkerError(f"no Dask scheduler answers at {address}: {error}") from error
        try:
            self._client.wait_for_workers(1, timeout=WORKERS_WITHIN)
        except TimeoutError as error:
            self.close()
            raise WorkerError(f"the Dask scheduler at {address} has no workers") from error
        self.workers = sum(self._client.nthreads().values())

    def run(self, work: Callable[[S, P], R], shared: S, batches: Sequence[P]) -> Iterator[R]:
        """See :meth:`LocalExecutor.run`."""
        from distributed import as_completed as completed
        from distributed.scheduler import KilledWorker

        client = self._client
        # A task and not scattered data, which would be lost with the workers that hold it.
        task = client.submit(lambda: shared, pure=False)
        # A batch whose worker dies is done again by another: nothing of it has come back.
        pending = [client.submit(work, task, batch, pure=False) for batch in batches]
        try:
            for future in completed(pending, loop=client.loop):
                yield future.result()
                future.release()
        except KilledWorker as error:
            raise WorkerError(f"{error}; the same command goes on with the rest") from error

    def close(self) -> None:
        """Let go of the cluster, which stays."""
        self._client.close()


Executor = LocalExecutor | DaskExecutor
