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
from urllib.parse import quote

SCRIPT, STYLE = "page_script.js", "page_style.css"
TITLE = "uav_tracking"
ICON = (
    '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 32 32">'
    '<rect width="32" height="32" rx="7" fill="#0b3a5b"/>'
    '<circle cx="16" cy="16" r="10.5" fill="none" stroke="#56b4e9" stroke-width="2" '
    'stroke-dasharray="4 2.6"/><circle cx="16" cy="16" r="2.4" fill="#e69f00"/>'
    '<path d="M26.5 5.2 22 14.2l-2.6-3.4-4.2-1z" fill="#fff"/></svg>'
)
ICON_LINK = f'<link rel="icon" href="data:image/svg+xml,{quote(ICON)}">'
FOREIGN_ICON = re.compile(r'<link\s+rel="icon".*?/?>', re.DOTALL)
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
        ValueError: It is no page of viser: it has no title, icon or end of its head.
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
    if not (end and icons and titles):
        raise ValueError("this is no page of viser: it has no title, icon or end of its head")
    # Before the bundle of viser, which begins to draw as soon as it is read.
    mark = before.index("<meta")
    return before[:mark] + head + before[mark:] + end + rest
