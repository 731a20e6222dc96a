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

"""Shared-memory files of Fast DDS: those of a killed process stay behind unless removed."""

from __future__ import annotations

import contextlib
import os
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
        """Remember the files that processes map now.

        Args:
            processes: Their process ids.
        """
        for process in processes:
            self._seen |= _mapped(Path(f"/proc/{process}"))

    def remove_orphans(self) -> None:
        """Remove every remembered file that no other living process maps.

        This process itself is done with them, though Fast DDS keeps some open until it ends.
        """
        for process in Path("/proc").glob("[0-9]*"):
            if process.name != str(os.getpid()):
                self._seen -= _mapped(process)
        for file in self._seen:
            # Its lock and its semaphore are never mapped: they go with the file that they guard.
            for name in (file.name, f"{file.name}_el", f"sem.{file.name}_mutex"):
                with contextlib.suppress(OSError):
                    (FOLDER / name).unlink()
        self._seen.clear()


def _mapped(process: Path) -> set[Path]:
    try:
        lines = (process / "maps").read_text(errors="replace").splitlines()
    except OSError:  # it has ended, or belongs to somebody else
        return set()
    names = {line.rpartition(" ")[2] for line in lines if f" {FOLDER}/" in line}
    return {Path(name) for name in names if "fastrtps" in name}
