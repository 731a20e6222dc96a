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

"""Run a function over many pieces of work, in processes, with a progress bar on stderr."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ProcessPoolExecutor
from typing import Any, TypeVar

P = TypeVar("P")
R = TypeVar("R")


class StoppedError(KeyboardInterrupt):
    """The user interrupted the work.

    Args:
        done: Results that came before, in the order of the pieces.

    Attributes:
        done: The same.
    """

    def __init__(self, done: list[Any]) -> None:
        super().__init__()
        self.done = done


def end_with_parent() -> None:
    """In a worker: leave Ctrl-C to the parent, and end when it is killed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = multiprocessing.parent_process()
    assert parent is not None

    def watch() -> None:
        parent.join()
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()


def parallel_map(
    function: Callable[[P], R],
    pieces: Sequence[P],
    workers: int | None = None,
    label: str = "",
    show: bool = True,
) -> list[R]:
    """Apply a function to every piece.

    Args:
        function: At module level, so that processes can find it.
        pieces: Its arguments; they must pickle.
        workers: Processes; one for each core by default; 1 stays in this process.
        label: What the progress bar says.
        show: Whether to show it.

    Returns:
        Results in the order of the pieces.

    Raises:
        StoppedError: The user interrupted; it holds the results that came before.
    """
    workers = min(workers or os.cpu_count() or 1, len(pieces))
    if workers < 2:
        return _shown(map(function, pieces), len(pieces), label, show)
    # spawn: a fork would copy whatever threads the caller has running.
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(workers, context, end_with_parent) as pool:
        return _shown(pool.map(function, pieces), len(pieces), label, show)


def _shown(results: Iterable[R], count: int, label: str, show: bool) -> list[R]:
    from rich.console import Console
    from rich.progress import track

    console, done = Console(stderr=True), []
    try:
        for result in track(results, label, total=count, console=console, disable=not show):
            done.append(result)
    except KeyboardInterrupt as error:
        raise StoppedError(done) from error
    return done
