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

"""What parts that change parameters share: widgets that follow what is flown."""

from __future__ import annotations

import math
import time
from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from uav_tracking_mpc.view.panel._steering_part import SteeringPart
from uav_tracking_mpc.view.sight import Sight

if TYPE_CHECKING:
    import viser

REST = 0.4  # s of wall time that a widget stands still before its value is sent
HANDS_OFF = 1.5  # s of wall time after which widgets follow what is flown again


@dataclass
class _Steered:
    """A widget: its value when it was looked at last, and whether that is to be sent."""

    name: str
    widget: Any  # mypy takes the value of viser's handles for one that cannot be set
    seen: Any
    wanted: bool = False


class ParameterPart(SteeringPart):
    """Widgets for parameters of ``node``.

    They appear when the parameters are known. A value is sent when its widget has come to rest. If
    it is refused, or somebody else changes it, the widget goes to what is flown.
    """

    period = 0.2

    def add(self) -> None:
        """Add the folder and wait for the parameters."""
        super().add()
        self._built = False
        self._steered: list[_Steered] = []
        self._touched = -math.inf
        self.say(f"waiting for the parameters of {self.node}")

    @abstractmethod
    def build(self, known: Mapping[str, Any]) -> None:
        """Add the widgets.

        Args:
            known: Parameters of the node by name.
        """

    @abstractmethod
    def follow(self, known: Mapping[str, Any]) -> None:
        """Set the widgets to what is flown.

        Args:
            known: Parameters of the node by name.
        """

    @abstractmethod
    def values(self, widget: str) -> dict[str, Any]:
        """Parameters that a widget asks for, by name.

        Args:
            widget: Name under which it was steered.
        """

    def steer(self, name: str, widget: viser.GuiInputHandle[Any]) -> None:
        """Send what a widget is set to by hand.

        Args:
            name: Of the widget.
            widget: What is set.
        """
        self._steered.append(_Steered(name, widget, widget.value))

        def moved(event: viser.GuiEvent[Any]) -> None:
            if event.client is not None:  # else this program has set it
                self.client = event.client

        widget.on_update(moved)

    def show(self, sight: Sight) -> None:
        """Send what has come to rest, or follow what is flown.

        Args:
            sight: Of this aircraft.
        """
        known = self.requests.parameters(self.node)
        if not known:
            return
        if not self._built:
            self._built = True
            self.say("")
            with self.folder:
                self.build(known)
        self._look_at_hands()
        still = time.monotonic() - self._touched
        wanted = [steered for steered in self._steered if steered.wanted]
        if wanted and still > REST and not self.asking:
            self._send(wanted)
        elif not wanted and still > HANDS_OFF and not self.asking:
            self.follow(known)
            for steered in self._steered:
                steered.seen = steered.widget.value

    def _look_at_hands(self) -> None:
        """Find widgets that were set by hand.

        By their values and not in their callbacks: those come later, in other threads.
        """
        for steered in self._steered:
            value = steered.widget.value
            if isinstance(value, float) and not math.isfinite(value):
                steered.widget.value = steered.seen
                self.say(f"{steered.widget.label} cannot be {value}", of="refused")
            elif value != steered.seen:
                steered.seen, steered.wanted = value, True
                self._touched = time.monotonic()

    def _send(self, wanted: list[_Steered]) -> None:
        values: dict[str, Any] = {}
        for steered in wanted:
            values |= self.values(steered.name)
            steered.wanted = False

        def answered(refusal: str) -> None:
            if refusal:
                self._touched = -math.inf  # what is flown is shown at once

        words = ", ".join(f"{name} {_short(value)}" for name, value in values.items())
        self.ask(words, lambda: self.requests.change(self.node, values), answered)


def _short(value: Any) -> str:
    if isinstance(value, (tuple, list)):
        return "[" + ", ".join(_short(element) for element in value) + "]"
    return f"{value:.4g}" if isinstance(value, float) else str(value)
