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

"""A folder for ROS's log files that can be written: rcl does not start without one."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

VARIABLE = "ROS_LOG_DIR"


def ensure_log_folder() -> str:
    """Let rcl log under the temporary directory where its own folder cannot be written.

    Its own is ``$ROS_LOG_DIR``, else ``$ROS_HOME/log``, else ``~/.ros/log``. Processes that are
    started from here inherit the choice.

    Returns:
        What was changed, in words; empty where nothing had to be.
    """
    wanted = _wanted()
    if wanted is not None and _writable(wanted):
        return ""
    user = os.getuid() if hasattr(os, "getuid") else "user"
    folder = Path(tempfile.gettempdir()) / f"ros-log-{user}"
    if not _writable(folder):
        folder = Path(tempfile.mkdtemp(prefix="ros-log-"))
    os.environ[VARIABLE] = str(folder)
    return f"log folder {wanted or '~/.ros/log'} cannot be written, {folder} is used instead"


def _wanted() -> Path | None:
    """Where rcl logs; None where it cannot know."""
    if folder := os.environ.get(VARIABLE):
        return _expanded(folder)
    home = _expanded(os.environ.get("ROS_HOME") or "~/.ros")
    return None if home is None else home / "log"


def _expanded(folder: str) -> Path | None:
    home = "HOME" if os.name == "posix" else "USERPROFILE"
    if folder.startswith("~") and not os.environ.get(home):  # rcl looks nowhere else
        return None
    return Path(folder).expanduser()


def _writable(folder: Path) -> bool:
    """Whether it is there, or can be made, and takes files."""
    try:
        folder.mkdir(mode=0o755, parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return True
    except OSError:
        return False
