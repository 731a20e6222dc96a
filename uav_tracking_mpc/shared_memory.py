"""Shared-memory files of Fast DDS: those of a killed process stay behind unless removed."""

from __future__ import annotations

import contextlib
from collections.abc import Iterable
from pathlib import Path

FOLDER = Path("/dev/shm")


class SharedMemoryFiles:
    """Remembers which files a group of processes maps, and removes them when nobody does.

    On systems without /proc and /dev/shm it does nothing.
    """

    def __init__(self) -> None:
        self._seen: set[Path] = set()

    def note(self, processes: Iterable[int]) -> None:
        """Remember the files that these process ids map now."""
        for process in processes:
            self._seen |= _mapped(Path(f"/proc/{process}"))

    def remove_orphans(self) -> None:
        """Remove every remembered file that no living process maps."""
        for process in Path("/proc").glob("[0-9]*"):
            self._seen -= _mapped(process)
        for file in self._seen:
            # An exclusive lock is never mapped: it goes with the file that it guards.
            for orphan in (file, file.with_name(f"{file.name}_el")):
                with contextlib.suppress(OSError):
                    orphan.unlink()
        self._seen.clear()


def _mapped(process: Path) -> set[Path]:
    try:
        lines = (process / "maps").read_text(errors="replace").splitlines()
    except OSError:  # it has ended, or belongs to somebody else
        return set()
    names = {line.rpartition(" ")[2] for line in lines if f" {FOLDER}/" in line}
    return {Path(name) for name in names if "fastrtps" in name}
