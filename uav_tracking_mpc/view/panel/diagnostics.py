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

"""What the nodes say of themselves."""

from __future__ import annotations

import html
from typing import TYPE_CHECKING

from uav_tracking_mpc.report.mode_colours import Colour
from uav_tracking_mpc.view.panel import PanelPart
from uav_tracking_mpc.view.panel._html import ALARM, ATTENTION, CALM, badge, block, faint, table
from uav_tracking_mpc.view.sight import NodeStatus, Sight
from uav_tracking_mpc.view.watched_flight import FlightSource, WatchedFlight

if TYPE_CHECKING:
    import viser

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
        self._folder = self.gui.add_folder("Diagnostics")
        with self._folder:
            self._lines = self.gui.add_html("", order=0.0)

    def show(self, sight: Sight) -> None:
        """Write what the nodes say now.

        Args:
            sight: Of this aircraft.
        """
        self._lines.content = block(*(_line(status) for status in sight.statuses))
        for status in sight.statuses:
            if not status.values:
                continue
            if status.node not in self._figures:
                with self._folder, self.gui.add_folder(status.node, expand_by_default=False):
                    self._figures[status.node] = self.gui.add_html("")
            rows = [(faint(key), html.escape(words)) for key, words in status.values.items()]
            self._figures[status.node].content = block(table(rows))


def _line(status: NodeStatus) -> str:
    level, colour = LEVELS[min(max(status.level, 0), len(LEVELS) - 1)]
    return f"<b>{html.escape(status.node)}</b> {badge(level, colour)} {html.escape(status.words)}"
