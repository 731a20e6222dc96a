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

"""Faults that can be injected, what they do, and how the flight recovered."""

from __future__ import annotations

import html

from uav_tracking_mpc.report.mode_colours import mode_colour
from uav_tracking_mpc.view.panel._html import CALM, badge, block, duration, faint
from uav_tracking_mpc.view.panel._steering_part import SteeringPart
from uav_tracking_mpc.view.sight import Sight
from uav_tracking_mpc.view.watched_flight import FlightSource, WatchedFlight

PATIENCE = 30.0  # s of the flight's clock in which a fault shows, or does not


class Faults(SteeringPart):
    """A button for each, and the story of the last one."""

    name, title = "faults", "Faults"
    order = 65.0

    @classmethod
    def fits(cls, flight: WatchedFlight, source: FlightSource) -> bool:
        """Whether there are faults to inject.

        Args:
            flight: What is steered.
            source: Where it comes from.
        """
        return flight.steering is not None and bool(flight.steering.faults)

    def add(self) -> None:
        """Add the buttons."""
        super().add()
        self._fault, self._begun, self._worst, self._story = "", False, None, ""
        self._since = self._left = self._now = float("nan")
        with self.folder:
            self._told = self.gui.add_html("", order=0.0, visible=False)
        self._offered: set[str] = set()
        self._add_offered()

    def _add_offered(self) -> None:
        """Add buttons for faults that are offered only now: nodes come one by one."""
        for fault, words in self.steering.faults.items():
            if fault not in self._offered:
                self._offered.add(fault)
                with self.folder:
                    self._add(fault, words)

    def _add(self, fault: str, words: str) -> None:
        def begun() -> None:
            self._since, self._left, self._worst = self._now, float("nan"), None
            self._story, self._fault, self._begun = "", fault, True

        self.add_button(fault, lambda: self.steering.inject(fault), words, begun)
        self.gui.add_html(block(faint(words)))

    def show(self, sight: Sight) -> None:
        """Tell what the last fault does to the flight.

        Args:
            sight: Of this aircraft.
        """
        self._now = sight.time
        self._add_offered()
        if not self._begun:
            return
        mode, since = sight.mode, sight.time - self._since
        lost = mode is None or not mode.nominal
        heading = f"<b>{html.escape(self._fault)}</b> {faint(duration(since) + ' ago')}"
        if lost:
            self._left = sight.time
            words = "no command yet" if mode is None else mode.value
            now = badge(words, mode_colour(mode))
            self._story = f"now flying {now} {html.escape(sight.reason)}"
        elif self._left == self._left:
            lasted = duration(self._left - self._since)
            self._story = f"{badge('recovered', CALM)} after {lasted}"
        elif since > PATIENCE:
            self._story = "no fallback was needed"
        else:
            self._story = "no fallback so far"
        self._told.content, self._told.visible = block(heading, self._story), True
