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

"""What is read and steered beside the scene.

================  ==================================================================================
``replay``        time of a recorded flight: a slider, play, pause and speed
``state``         what mode is flown and how long; folded, what was flown before and what nodes say
``readings``      whether it is well: in words, by the nearest limit and by the worst sensor; the
                  numbers of the flight: value, error and limits; folded, range error, bank and
                  cost over the last minutes, and how long solves take
``steered``       orbit, target, wind, faults and simulated time, whether the controller commands,
                  range errors of guidance laws that are flown beside
``mission_file``  how it was steered, as a file to save and to bring back
================  ==================================================================================

A part is a subclass of :class:`PanelPart`. It is found by its ``name``, or by an entry point in the
group ``uav_tracking_mpc.view.panel``.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import ClassVar

import viser

from uav_tracking_mpc.parameters.registry import ExtensionPoint
from uav_tracking_mpc.view.watched_flight import FlightSource, Sight, WatchedFlight

FOLDED = 1e5  # order of a folder in its panel that is folded at first: below all that is not


class PanelPart(ABC):
    """A folder of the panel of one aircraft.

    Args:
        gui: Where to add it.
        flight: What is read and steered.
        source: Where the flight comes from.

    Attributes:
        name: By which it is found.
        order: Parts stand in this order, the least on top.
        period: Time between updates in [s].
    """

    name: ClassVar[str]
    order: ClassVar[float] = 50.0
    period: ClassVar[float] = 0.25

    def __init__(self, gui: viser.GuiApi, flight: WatchedFlight, source: FlightSource) -> None:
        self.gui, self.flight, self.source = gui, flight, source
        self.add()

    @classmethod
    def fits(cls, flight: WatchedFlight, source: FlightSource) -> bool:
        """Whether there is something to show; asked again until there is.

        Args:
            flight: What is read and steered.
            source: Where it comes from.
        """
        return True

    @abstractmethod
    def add(self) -> None:
        """Add its widgets, once."""

    def show(self, sight: Sight) -> None:  # noqa: B027, a part may be one that never changes
        """Update it; by default nothing changes by itself.

        Args:
            sight: Of this aircraft.
        """


PANEL_PART = ExtensionPoint("part of the panel", PanelPart)
