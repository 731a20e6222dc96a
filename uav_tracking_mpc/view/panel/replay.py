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

"""Time of a recorded flight: a slider over the record, play, pause and speed."""

from __future__ import annotations

import math
import time
from typing import Any

from uav_tracking_mpc.view.panel import PanelPart
from uav_tracking_mpc.view.panel._html import clock
from uav_tracking_mpc.view.watched_flight import RATES, FlightSource, Sight, WatchedFlight

STEP = 0.1  # s of the slider
SAME = 1e-6  # of it: what rounding leaves
HAND = 1.0  # s for which the slider is left to who has just moved it
JUMPS = {"-1 min": -60.0, "-10 s": -10.0, "+10 s": 10.0, "+1 min": 60.0}  # s
SPEEDS = {f"{rate:g}x": rate for rate in RATES}


class Replay(PanelPart):
    """Follows the clock of the record, and moves it; once for all aircraft and all pages."""

    name = "replay"
    order = 0.0
    period = 0.1

    @classmethod
    def fits(cls, flight: WatchedFlight, source: FlightSource) -> bool:
        """Whether it is a record, and the first aircraft of it.

        Args:
            flight: What is read and steered.
            source: Where it comes from.
        """
        return source.clock is not None and source.flights()[0] is flight

    def add(self) -> None:
        """Add slider and buttons."""
        assert self.source.clock is not None, "there is no such part without it"
        self.clock = record = self.source.clock
        self._moved = -HAND  # when somebody moved the slider, steady [s]
        self._words = self.gui.add_markdown("")
        # mypy takes a handle's value for one that cannot be set.
        self._slider: Any = self.gui.add_slider(
            "time [s]",
            min=math.floor(record.begin / STEP + SAME) * STEP,
            max=math.ceil(record.end / STEP - SAME) * STEP,
            step=STEP,
            initial_value=round(record.time, 1),
        )
        self._at = self._slider.value  # as it was looked at last
        self._button = self.gui.add_button("")
        self._speed: Any = self.gui.add_dropdown(
            "speed", tuple(SPEEDS), initial_value=f"{record.rate:g}x"
        )
        self._rate = self._speed.value  # as it was looked at last
        jumps = self.gui.add_button_group("jump", tuple(JUMPS))
        self._button.on_click(lambda _: self._toggle())
        jumps.on_click(lambda event: self._jump(JUMPS.get(event.target.value, 0.0)))
        self._write()

    def show(self, sight: Sight) -> None:
        """Hear what was set by hand, and follow the clock.

        By the widgets' values and not in their callbacks: those come later, in other threads, when
        the value may be that of the clock again.

        Args:
            sight: Of the first aircraft.
        """
        at, rate = self._slider.value, self._speed.value
        if at != self._at and math.isfinite(at):
            self._at, self._moved = at, time.monotonic()
            self.clock.seek(at)
        if rate != self._rate:
            self.clock.rate = SPEEDS.get(rate, self.clock.rate)
        self._write()

    def _write(self) -> None:
        record = self.clock
        self._words.content = f"**{clock(record.time)}** of {clock(record.end)}"
        self._button.label = "pause" if record.playing else "play"
        self._rate = self._speed.value = f"{record.rate:g}x"
        if time.monotonic() - self._moved >= HAND:
            # In whole steps, which the field beside the slider has room for.
            self._at = self._slider.value = round(record.time, 1)

    def _jump(self, step: float) -> None:
        self.clock.seek(self.clock.time + step)
        self._moved = -HAND

    def _toggle(self) -> None:
        if self.clock.playing:
            self.clock.pause()
        else:
            self.clock.play()
