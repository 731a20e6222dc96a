"""Run a function over many pieces of work, in processes, with a progress bar on stderr."""

from __future__ import annotations

import multiprocessing
import sys
from collections.abc import Callable, Sequence
from typing import Any


def parallel_map(
    function: Callable[[Any], Any],
    pieces: Sequence[Any],
    workers: int | None = None,
    label: str = "",
    show: bool = True,
) -> list[Any]:
    """Results of ``function`` on every piece, in order.

    Args:
        function: At module level, so that processes can find it.
        pieces: Its arguments; they must pickle.
        workers: Processes; all cores by default; 1 stays in this process.
        label: What the progress bar says.
        show: Whether to show it (needs rich).
    """
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TimeRemainingColumn

    workers = workers or multiprocessing.cpu_count()
    columns = ("{task.description}", BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    console = Console(file=sys.stderr)
    with Progress(*columns, console=console, disable=not show) as progress:
        task = progress.add_task(label, total=len(pieces))
        results = []
        if workers == 1 or len(pieces) < 2:
            for piece in pieces:
                results.append(function(piece))
                progress.advance(task)
            return results
        # spawn: a fork would copy whatever threads the caller has running.
        with multiprocessing.get_context("spawn").Pool(min(workers, len(pieces))) as pool:
            for result in pool.imap(function, pieces):
                results.append(result)
                progress.advance(task)
    return results
