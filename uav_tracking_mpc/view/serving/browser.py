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

"""Opens a page in the browser of the user, where there is one to look at."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Mapping


def is_watched(environment: Mapping[str, str] = os.environ, platform: str = sys.platform) -> bool:
    """Whether a person sits before a screen on which this process may open a window.

    Args:
        environment: Variables of the process.
        platform: As ``sys.platform``.
    """
    if environment.get("CI", "").lower() not in ("", "0", "false"):
        return False
    if platform in ("darwin", "win32"):
        return "SSH_CONNECTION" not in environment
    return bool(environment.get("DISPLAY") or environment.get("WAYLAND_DISPLAY"))


def open_browser(address: str) -> None:
    """Open a page without waiting for it; a browser that does not start is nobody's failure.

    Args:
        address: Of the page. Other users of this machine can read it in the list of processes, so
            that it must hold no token.
    """
    subprocess.Popen(
        [sys.executable, "-m", "webbrowser", address],  # a browser's own words are not ours
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    )
