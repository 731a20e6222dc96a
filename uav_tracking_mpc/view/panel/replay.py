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

import viser

from uav_tracking_mpc.view.panel import PanelPart
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
        self.clock = clock = self.source.clock
        self._moved = -HAND  # when somebody moved the slider, steady [s]
        self._words = self.gui.add_markdown(self._time_in_words())
        # mypy takes a handle's value for one that cannot be set.
        self._slider: Any = self.gui.add_slider(
            "time [s]",
            min=math.floor(clock.begin / STEP + SAME) * STEP,
            max=math.ceil(clock.end / STEP - SAME) * STEP,
            step=STEP,
            initial_value=self._shown(),
        )
        self._button = self.gui.add_button("")
        self._label()
        self._speed: Any = self.gui.add_dropdown(
            "speed", tuple(SPEEDS), initial_value=f"{clock.rate:g}x"
        )
        self._jumps = self.gui.add_button_group("jump", tuple(JUMPS))
        self._slider.on_update(self._slide)
        self._button.on_click(lambda _: self._toggle())
        self._speed.on_update(lambda _: self._change_speed())
        self._jumps.on_click(lambda event: self._jump(JUMPS.get(event.target.value, 0.0)))

    def show(self, sight: Sight) -> None:
        """Follow the clock.

        Args:
            sight: Of the first aircraft.
        """
        self._words.content = self._time_in_words()
        self._label()
        self._speed.value = f"{self.clock.rate:g}x"
        if time.monotonic() - self._moved >= HAND:
            self._slider.value = self._shown()

    def _shown(self) -> float:
        """In whole steps, which the field beside the slider has room for."""
        return round(self.clock.time, 1)

    def _slide(self, event: viser.GuiEvent[viser.GuiSliderHandle[float]]) -> None:
        if event.client is not None and math.isfinite(event.target.value):  # by hand
            self._moved = time.monotonic()
            self.clock.seek(event.target.value)

    def _jump(self, step: float) -> None:
        self.clock.seek(self.clock.time + step)
        self._moved = -HAND

    def _toggle(self) -> None:
        if self.clock.playing:
            self.clock.pause()
        else:
            self.clock.play()
        self._label()

    def _change_speed(self) -> None:
        self.clock.rate = SPEEDS.get(self._speed.value, self.clock.rate)

    def _label(self) -> None:
        self._button.label = "pause" if self.clock.playing else "play"

    def _time_in_words(self) -> str:
        return f"**{clock_words(self.clock.time)}** of {clock_words(self.clock.end)}"


def clock_words(seconds: float) -> str:
    """A time as a clock shows it, such as ``1:02:03.4``.

    Args:
        seconds: In [s]; before the first command it is negative.
    """
    sign = "-" if seconds < 0.0 else ""
    minutes, rest = divmod(round(abs(seconds) * 10), 600)
    hours, minutes = divmod(minutes, 60)
    front = f"{hours}:{minutes:02d}" if hours else f"{minutes}"
    return f"{sign}{front}:{rest // 10:02d}.{rest % 10}"
