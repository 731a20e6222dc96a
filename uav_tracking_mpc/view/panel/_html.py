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

"""How parts of the panel write: numbers, badges and tables, on a light page and on a dark one."""

from __future__ import annotations

import html
import math
from collections.abc import Iterable, Sequence
from datetime import datetime, timezone

from uav_tracking_mpc.control.fallback import FallbackMode
from uav_tracking_mpc.report.mode_colours import Colour, mode_colour, mode_words

DASH = "–"  # noqa: RUF001, a value that there is not
ATTENTION: Colour = (230, 159, 0)
ALARM: Colour = (213, 94, 0)
CALM: Colour = (0, 158, 115)
FAINT = "color:var(--mantine-color-dimmed)"
EPOCH = 1e8  # s; a clock that is beyond that counts from 1970


def number(value: float, digits: int = 1, signed: bool = False) -> str:
    """A number as people read it, a dash where it is not finite.

    Args:
        value: In any unit [-].
        digits: Behind the point.
        signed: Whether a plus stands before it.
    """
    if not math.isfinite(value):
        return DASH
    rounded = round(value, digits) + 0.0  # no -0.0
    return f"{rounded:{'+' if signed else ''}.{digits}f}"


def duration(seconds: float) -> str:
    """How long something lasts.

    Args:
        seconds: Of the flight's clock in [s].
    """
    minutes, rest = divmod(round(seconds), 60)
    return f"{minutes} min {rest} s" if minutes else f"{rest} s"


def clock(time: float) -> str:
    """Time of a flight as a clock shows it, such as ``1:02:03.4``, as page_script.js writes it.

    Args:
        time: Of the flight's clock in [s], since its start, where it may be negative, or 1970.
    """
    if time > EPOCH:
        return f"{datetime.fromtimestamp(time, timezone.utc):%H:%M:%S} UTC"
    minutes, rest = divmod(round(abs(time) * 10), 600)
    hours, minutes = divmod(minutes, 60)
    front = f"{hours}:{minutes:02d}" if hours else f"{minutes}"
    return f"{'-' if time < 0.0 else ''}{front}:{rest // 10:02d}.{rest % 10}"


def badge(words: str, colour: Colour) -> str:
    """Words on a colour, black or white, whichever is read more easily.

    Args:
        words: What it says.
        colour: Behind them.
    """
    linear = [
        (c / 255.0 / 12.92 if c < 10 else ((c / 255.0 + 0.055) / 1.055) ** 2.4) for c in colour
    ]
    luminance = 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]
    ink = "#000" if luminance > 0.179 else "#fff"
    return (
        f'<span style="background:rgb{colour};color:{ink};border-radius:0.25em;padding:0 0.4em;'
        f'white-space:nowrap">{html.escape(words)}</span>'
    )


def mode_badge(mode: FallbackMode | None) -> str:
    """What is flown, on its colour.

    Args:
        mode: None before the first command.
    """
    return badge(mode_words(mode), mode_colour(mode))


def faint(words: str) -> str:
    """Words that stand back.

    Args:
        words: What it says.
    """
    return f'<span style="{FAINT}">{html.escape(words)}</span>'


def table(rows: Iterable[Sequence[str]], head: Sequence[str] = ()) -> str:
    """A table as wide as the panel; its first column reads from the left, the others end right.

    Args:
        rows: Cells, as HTML.
        head: Of the columns, as HTML.
    """
    written = [_row(head, f"{FAINT};font-size:0.9em")] if head else []
    written += [_row(cells, "") for cells in rows]
    return f'<table style="width:100%;border-collapse:collapse">{"".join(written)}</table>'


def gauge(words: str, share: float, colour: Colour) -> str:
    """Words upon a bar.

    Args:
        words: What it says.
        share: How far the bar goes, from 0 to 1; beyond that it is full.
        colour: Of the bar.
    """
    width = 100.0 * min(max(share, 0.0), 1.0) if math.isfinite(share) else 0.0
    red, green, blue = colour
    return (
        '<div style="padding:0 0.4em;border-radius:0.25em;background:linear-gradient(90deg,'
        f"rgba({red},{green},{blue},0.45) {width:.0f}%,rgba(128,128,128,0.15) {width:.0f}%)"
        f'">{html.escape(words)}</div>'
    )


def block(*parts: str) -> str:
    """What a part shows, one below the other.

    Args:
        parts: As HTML; empty ones are left out.
    """
    rows = "".join(f'<div style="padding-bottom:0.2em">{part}</div>' for part in parts if part)
    return f'<div style="font-size:0.8em;line-height:1.35;padding:0 0.9em">{rows}</div>'


def _row(cells: Sequence[str], style: str) -> str:
    first, *others = cells
    written = [f'<td style="padding:0">{first}</td>']
    written += [
        '<td style="padding:0 0 0 0.5em;text-align:right;font-variant-numeric:tabular-nums">'
        f"{cell}</td>"
        for cell in others
    ]
    return f'<tr style="{style}">{"".join(written)}</tr>'
