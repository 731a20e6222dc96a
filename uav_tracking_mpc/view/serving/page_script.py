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

"""Puts the script of the page, and its own title and icon, into what viser serves or records."""

from __future__ import annotations

import html
import json
import re
from functools import lru_cache
from importlib import resources
from typing import Any

from uav_tracking_mpc.report.pages import ICON_ADDRESS

SCRIPT, STYLE = "page_script.js", "page_style.css"
TITLE = "uav_tracking"
ICON_LINK = f'<link rel="icon" href="{ICON_ADDRESS}">'
FOREIGN_ICON = re.compile(r'<link\s+rel="icon".*?/?>', re.DOTALL)
CHARSET = re.compile(r"<meta charset[^>]*>")
FOREIGN_TITLE = re.compile(r"<title>.*?</title>", re.DOTALL)


@lru_cache
def own(name: str) -> str:
    """A file of this room, as it is served.

    Args:
        name: SCRIPT or STYLE.
    """
    return resources.files("uav_tracking_mpc.view.serving").joinpath(name).read_text("utf-8")


def with_script(page: str, title: str = TITLE, record: dict[str, Any] | None = None) -> str:
    """A page of viser with the script.

    Args:
        page: As viser made it.
        title: Of the tab.
        record: What the strip of a recorded scene draws, without nan; a page of a server has none.

    Raises:
        ValueError: It is no page of viser: it lacks a title, icon, charset or end of its head.
    """
    # Whatever is in the data, "<" ends no script.
    data = json.dumps(record, allow_nan=False, separators=(",", ":")).replace("<", "\\u003c")
    head = (
        f"<title>{html.escape(title)}</title>{ICON_LINK}"
        '<meta name="color-scheme" content="light dark">'
        f"<style>{own(STYLE)}</style>"
        f"<script>window.__FLIGHT_RECORD__={data};</script><script>{own(SCRIPT)}</script>"
    )
    before, end, rest = page.partition("</head>")
    before, icons = FOREIGN_ICON.subn("", before, count=1)
    before, titles = FOREIGN_TITLE.subn("", before, count=1)
    charset = CHARSET.search(before)
    if not (end and icons and titles and charset):
        raise ValueError("this is no page of viser: it lacks a title, icon, charset or end of head")
    # After the charset, which stands among the first bytes; before the bundle of viser.
    mark = charset.end()
    return before[:mark] + head + before[mark:] + end + rest
