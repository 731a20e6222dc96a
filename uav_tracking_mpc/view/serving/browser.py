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

import html
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

LEADS_TO = """<!doctype html>
<meta charset="utf-8">
<meta name="referrer" content="no-referrer">
<meta http-equiv="refresh" content="0; url={0}">
<a href="{0}">The page of the flight</a>
"""


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


@contextmanager
def open_browser(address: str) -> Iterator[None]:
    """Open a page without waiting for it; a browser that does not start is nobody's failure.

    Other users of this machine can read the list of processes. So the browser is given a file that
    this user alone can read, which leads to the page. The file is gone when the context ends.

    Args:
        address: Of the page, with its token.
    """
    # In the home folder: a browser that is a snap has another /tmp.
    home = os.path.expanduser("~")
    with tempfile.NamedTemporaryFile(
        "w",
        prefix="uav_tracking_page_",
        suffix=".html",
        dir=home if os.access(home, os.W_OK) else None,
    ) as file:
        file.write(LEADS_TO.format(html.escape(address)))
        file.flush()
        subprocess.Popen(
            [sys.executable, "-m", "webbrowser", Path(file.name).as_uri()],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            start_new_session=True,
        )
        yield
