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

"""What is flown, why, how long, and what was flown before; what the nodes say of themselves."""

from __future__ import annotations

import html
import math
from collections import deque
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import viser

from uav_tracking_mpc.control.fallback import FallbackMode
from uav_tracking_mpc.report.mode_colours import Colour, mode_words
from uav_tracking_mpc.view.panel import FOLDED, PanelPart
from uav_tracking_mpc.view.panel._html import (
    ALARM,
    ATTENTION,
    CALM,
    badge,
    block,
    clock,
    duration,
    faint,
    mode_badge,
    table,
)
from uav_tracking_mpc.view.panel.readings import MARGIN
from uav_tracking_mpc.view.watched_flight import FlightSource, NodeStatus, Sight, WatchedFlight

MOST = 3000  # modes that are kept
SPAN = 300.0  # s
SHOWN = 5  # fallbacks
SETTLED = 0.5  # s, how long after a change its reason may still come
TOGETHER = 2.0  # s; the same fallback again within that time is told as one


@dataclass
class Spell:
    """A mode while it is flown.

    Attributes:
        mode: What is flown; None before the first command.
        begin: Of the flight's clock in [s].
        end: So far, of the flight's clock in [s].
        reason: Why it is not optimal, in words; empty if it is.
        cut: Whether it may have begun before what is known of the flight.
        times: How often it came.
    """

    mode: FallbackMode | None
    begin: float
    end: float
    reason: str
    cut: bool = False
    times: int = 1

    @property
    def lasted(self) -> str:
        """How long, in words."""
        return f"{'more than ' if self.cut else ''}{duration(self.end - self.begin)}"


class State(PanelPart):
    """The mode on its colour; folded, why, what was flown before it, and the last fallbacks."""

    name = "state"
    order = 5.0

    def add(self) -> None:
        """Begin with nothing."""
        self._last = -math.inf  # s, when it was seen last
        self._spells: deque[Spell] = deque(maxlen=MOST)
        self._now = self.gui.add_html("")
        self._folder = self.gui.add_folder("History", order=FOLDED, expand_by_default=False)
        with self._folder:
            self._before = self.gui.add_html("")

    def show(self, sight: Sight) -> None:
        """Write the mode of now and the last fallbacks.

        Args:
            sight: Of this aircraft.
        """
        since = self._last
        if not 0.0 <= sight.time - since <= SPAN:  # as the slider of a record does it
            self._spells.clear()
            since = sight.time - SPAN
        for seen in (*self.flight.past(sight.time - since + MARGIN), sight):
            if since < seen.time <= sight.time:
                self._note(seen)
        self._last = sight.time
        told = fallbacks(self._spells)
        times = sum(fallback.times for fallback in told)
        words = f"{times} fallback{'s' if times > 1 else ''}" if times else "no fallback"
        self._folder.label = f"History: {words}"
        self._write(sight, told)

    def _note(self, seen: Sight) -> None:
        now = self._spells[-1] if self._spells else None
        if now is not None:
            now.end = seen.time
        if now is None or seen.mode is not now.mode:
            spell = Spell(seen.mode, seen.time, seen.time, seen.reason, cut=now is None)
            self._spells.append(spell)
        elif not now.reason and now.end - now.begin < SETTLED:
            now.reason = seen.reason

    def _write(self, sight: Sight, told: Sequence[Spell]) -> None:
        """What is flown now, and what was before."""
        before, now = [None, None, *self._spells][-2:]
        if now is None or now.mode is not sight.mode:
            before = now = None
        since = "" if now is None else faint(f"for {now.lasted}")
        flown = f'<span style="font-size:1.2em">{mode_badge(sight.mode)}</span> {since}'
        self._now.content = block(flown)
        self._before.content = block(
            html.escape(sight.reason),
            "" if before is None else faint(f"before: {mode_words(before.mode)}, {before.lasted}"),
            *(_told(fallback) for fallback in reversed(told)),
        )


def fallbacks(spells: Iterable[Spell]) -> list[Spell]:
    """The last fallbacks, oldest first; those of one mode that follow each other soon are one.

    Args:
        spells: All modes that were flown, oldest first.
    """
    told: list[Spell] = []
    for spell in spells:
        if spell.mode is None or spell.mode.nominal:
            continue
        last = told[-1] if told else None
        if last is None or spell.mode is not last.mode or spell.begin > last.end + TOGETHER:
            told.append(spell)
        else:
            reason, times = spell.reason or last.reason, last.times + 1
            told[-1] = replace(last, end=spell.end, reason=reason, times=times)
    return told[-SHOWN:]


def _told(fallback: Spell) -> str:
    times = f", {fallback.times} times" if fallback.times > 1 else ""
    when = faint(f"{clock(fallback.begin)}, {fallback.lasted}{times}")
    return f"{when} {mode_badge(fallback.mode)} {html.escape(fallback.reason)}"


SILENT: Colour = (128, 128, 128)
LEVELS = (("ok", CALM), ("warning", ATTENTION), ("error", ALARM), ("silent", SILENT))


class Diagnostics(PanelPart):
    """A line for each node; their figures fold out."""

    name = "diagnostics"
    order = 70.0
    period = 1.0

    @classmethod
    def fits(cls, flight: WatchedFlight, source: FlightSource) -> bool:
        """Whether a node has said something.

        Args:
            flight: What is read.
            source: Where it comes from.
        """
        sight = flight.sight
        return sight is not None and bool(sight.statuses)

    def add(self) -> None:
        """Add an empty list, and a folder for each node as it appears."""
        self._figures: dict[str, viser.GuiHtmlHandle] = {}
        self._folder = self.gui.add_folder("Diagnostics", order=FOLDED, expand_by_default=False)
        with self._folder:
            self._lines = self.gui.add_html("", order=0.0)

    def show(self, sight: Sight) -> None:
        """Write what the nodes say now.

        Args:
            sight: Of this aircraft.
        """
        self._lines.content = block(*(_line(status) for status in sight.statuses))
        worst = max((_level(status) for status in sight.statuses), default=0)
        self._folder.label = f"Diagnostics: {LEVELS[worst][0]}"
        for status in sight.statuses:
            if not status.values:
                continue
            if status.node not in self._figures:
                with self._folder, self.gui.add_folder(status.node, expand_by_default=False):
                    self._figures[status.node] = self.gui.add_html("")
            rows = [(faint(key), html.escape(words)) for key, words in status.values.items()]
            self._figures[status.node].content = block(table(rows))


def _level(status: NodeStatus) -> int:
    return min(max(status.level, 0), len(LEVELS) - 1)


def _line(status: NodeStatus) -> str:
    level, colour = LEVELS[_level(status)]
    return f"<b>{html.escape(status.node)}</b> {badge(level, colour)} {html.escape(status.words)}"
