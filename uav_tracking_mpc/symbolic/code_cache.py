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

"""Where machine code is kept: XDG cache, or a directory of this user's under temp."""

from __future__ import annotations

import contextlib
import os
import tempfile
from collections.abc import Iterator
from functools import cache
from pathlib import Path


def cache_directory() -> Path:
    """The first of the places that can be written."""
    for place in places():
        try:
            place.mkdir(mode=0o700, parents=True, exist_ok=True)
            with tempfile.TemporaryFile(dir=place):
                pass
        except OSError:
            continue
        if ours(place):
            return place
    return _last_resort()


def places() -> Iterator[Path]:
    """Where machine code may be; the first one that can be written takes new."""
    base = os.environ.get("XDG_CACHE_HOME") or "~/.cache"
    with contextlib.suppress(RuntimeError):  # nobody knows where this user's home is
        yield Path(base).expanduser() / "uav_tracking_mpc"
    user = os.getuid() if hasattr(os, "getuid") else "user"
    yield Path(tempfile.gettempdir()) / f"uav_tracking_mpc-{user}"


@cache
def _last_resort() -> Path:
    return Path(tempfile.mkdtemp(prefix="uav_tracking_mpc-"))


def ours(place: Path) -> bool:
    """Whether nobody but this user and root can have written there: machine code is run from it.

    Args:
        place: One of :func:`places`.
    """
    if not hasattr(os, "getuid"):
        return True
    try:
        found = place.stat()
        return found.st_uid in (os.getuid(), 0) and not found.st_mode & 0o022
    except OSError:
        return False


def write(path: Path, content: bytes) -> None:
    """Write a file in one step, however many processes do.

    Args:
        path: Of the file.
        content: For it.
    """
    with tempfile.NamedTemporaryFile(dir=path.parent, prefix=f"{path.name}.", delete=False) as file:
        draft = Path(file.name)
        try:
            file.write(content)
            file.close()
            draft.replace(path)
        except OSError:
            draft.unlink()
            raise
