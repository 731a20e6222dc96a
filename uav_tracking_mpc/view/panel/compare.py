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

"""Guidance laws beside the flight: a checkbox, and their range errors beside its own."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from uav_tracking_mpc.view.panel._html import block, number, table
from uav_tracking_mpc.view.panel._steering_part import SteeringPart
from uav_tracking_mpc.view.panel.state import Recent
from uav_tracking_mpc.view.watched_flight import FlightSource, Sight, WatchedFlight

SPAN = 60.0  # s
OURS = "flown"


class Compare(SteeringPart):
    """Folded: the checkbox, and a table with the error of now and the RMS of the last minute."""

    name = "compare"
    title = "Compare"
    order = 40.0

    @classmethod
    def fits(cls, flight: WatchedFlight, source: FlightSource) -> bool:
        """Whether laws can be flown beside.

        Args:
            flight: What is compared.
            source: Where it comes from.
        """
        return flight.steering is not None and flight.steering.comparable

    def add(self) -> None:
        """Add the checkbox."""
        super().add()
        self._laws: tuple[str, ...] = ()
        with self.folder:
            self._wanted: Any = self.gui.add_checkbox(
                "classical laws",
                False,
                hint="They begin where the aircraft is, in the same air about the same target.",
            )
            self._table = self.gui.add_html("", visible=False)
        self._wanted.on_update(self._ask)

    def _ask(self, event: Any) -> None:
        on = bool(self._wanted.value)
        self.client = event.client or self.client
        self._laws = ()
        self.ask("laws beside", lambda: self.steering.compare(on), lambda refusal: None)

    def show(self, sight: Sight) -> None:
        """Write the errors.

        Args:
            sight: Of this aircraft.
        """
        self._table.visible = bool(sight.rivals)
        if not sight.rivals:
            return
        laws = tuple(rival.law for rival in sight.rivals)
        if laws != self._laws:
            self._laws = laws
            self._recent = Recent(self.flight, SPAN, lambda seen: _errors(seen, laws))
        _, *past = self._recent.columns(sight)
        rows = [
            (name, number(now, signed=True), number(_rms(each)))
            for name, now, each in zip((OURS, *laws), _errors(sight, laws), past, strict=True)
        ]
        self._table.content = block(table(rows, ("range error in m", "now", "RMS, last minute")))


def _errors(seen: Sight, laws: tuple[str, ...]) -> tuple[float, ...]:
    """Ours, then theirs; nan where one was not flown."""
    theirs = {rival.law: rival.range_error for rival in seen.rivals}
    ours = seen.errors.get("range_error", math.nan) if theirs else math.nan
    return ours, *(theirs.get(law, math.nan) for law in laws)


def _rms(errors: np.ndarray) -> float:
    known = errors[np.isfinite(errors)]
    return float(np.sqrt(np.mean(known**2))) if len(known) else math.nan
