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

"""What mode is flown, why, how long, and what was flown before."""

from __future__ import annotations

import html
from collections import deque
from dataclasses import dataclass, replace

from uav_tracking_mpc.control.fallback import FallbackMode
from uav_tracking_mpc.report.mode_colours import mode_colour
from uav_tracking_mpc.view.panel import PanelPart
from uav_tracking_mpc.view.panel._html import badge, block, clock, duration, faint, table
from uav_tracking_mpc.view.panel._recent import Recent
from uav_tracking_mpc.view.sight import Sight

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
    """The mode on its colour, what was flown before it, and the last fallbacks."""

    name = "state"
    order = 5.0

    def add(self) -> None:
        """Begin with nothing."""
        self._recent = Recent(self.flight, SPAN)
        self._spells: deque[Spell] = deque(maxlen=2)
        self._fallbacks: deque[Spell] = deque(maxlen=SHOWN)
        self._now = self.gui.add_html("")

    def show(self, sight: Sight) -> None:
        """Write the mode of now and the last fallbacks.

        Args:
            sight: Of this aircraft.
        """
        news = self._recent.take(sight)
        if self._recent.anew:
            self._spells.clear()
            self._fallbacks.clear()
        for seen in news:
            self._note(seen)
        self._now.content = self._words(sight)

    def _note(self, seen: Sight) -> None:
        now = self._spells[-1] if self._spells else None
        if now is not None:
            now.end = seen.time
            if _falls_back(now.mode):
                self._fallbacks[-1].end = seen.time
        if now is None or seen.mode is not now.mode:
            now = Spell(seen.mode, seen.time, seen.time, seen.reason, cut=now is None)
            self._spells.append(now)
        elif not now.reason and now.end - now.begin < SETTLED:
            now.reason = seen.reason
        if _falls_back(seen.mode):
            self._note_fallback(now)

    def _note_fallback(self, now: Spell) -> None:
        last = self._fallbacks[-1] if self._fallbacks else None
        if last is None or now.mode is not last.mode or now.begin > last.end + TOGETHER:
            self._fallbacks.append(replace(now))
            return
        last.times += now.begin > last.end
        last.end, last.reason = max(now.end, last.end), now.reason or last.reason

    def _words(self, sight: Sight) -> str:
        now = self._spells[-1] if self._spells else None
        known = now is not None and now.mode is sight.mode
        since = f"for {now.lasted}" if now is not None and known else ""
        before = self._spells[0] if len(self._spells) > 1 and known else None
        flown = f'<span style="font-size:1.2em">{_mode(sight.mode)}</span> {faint(since)}'
        return block(
            table([[flown, clock(sight.time)]]),
            html.escape(sight.reason),
            "" if before is None else faint(f"before: {_name(before.mode)}, {before.lasted}"),
            *(_told(fallback) for fallback in reversed(self._fallbacks)),
        )


def _falls_back(mode: FallbackMode | None) -> bool:
    return mode is not None and not mode.nominal


def _told(fallback: Spell) -> str:
    times = f", {fallback.times} times" if fallback.times > 1 else ""
    when = faint(f"{clock(fallback.begin)}, {fallback.lasted}{times}")
    return f"{when} {_mode(fallback.mode)} {html.escape(fallback.reason)}"


def _name(mode: FallbackMode | None) -> str:
    return "no command yet" if mode is None else mode.value


def _mode(mode: FallbackMode | None) -> str:
    return badge(_name(mode), mode_colour(mode))
