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

"""The numbers of the flight: value, error and limits."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from uav_tracking_mpc.parameters.specification import specifications
from uav_tracking_mpc.settings.tracking import TrackingParameters
from uav_tracking_mpc.view.panel import PanelPart
from uav_tracking_mpc.view.panel._html import ALARM, ATTENTION, badge, block, faint, number, table
from uav_tracking_mpc.view.sight import Sight

AT_LIMIT = 0.02  # of what lies between the limits
DEGREES = math.degrees(1.0)
KNOWN = {known.name: known for known in specifications(TrackingParameters)}


class Reading(NamedTuple):
    """One number.

    Attributes:
        name: What it is.
        unit: In which it is shown.
        value: In that unit [-].
        error: In that unit [-], nan where there is none.
        least: Limit in that unit [-], -inf where there is none.
        most: Limit in that unit [-], inf where there is none.
        digits: Behind the point.
    """

    name: str
    unit: str
    value: float
    error: float = math.nan
    least: float = -math.inf
    most: float = math.inf
    digits: int = 1

    @property
    def mark(self) -> str:
        """How it stands to its limits, in words; empty inside of them."""
        span = self.most - self.least
        near = AT_LIMIT * span if math.isfinite(span) else 0.0
        if self.value > self.most or self.value < self.least:
            return "beyond limit"
        if self.value >= self.most - near or self.value <= self.least + near:
            return "at limit"
        return ""


def readings(sight: Sight, tracking: TrackingParameters | None) -> list[Reading]:
    """What there is to read.

    Args:
        sight: Of the aircraft.
        tracking: What its controller flies by; None where that is not known.
    """
    target = None if sight.target is None else sight.target.position
    line = np.full(3, math.nan) if target is None else sight.position - target
    error = {name: sight.errors.get(f"{name}_error", math.nan) for name in ERRORS}
    floor = _limit(tracking, "height_min", -math.inf) - (0.0 if target is None else target[2])
    bank = _limit(tracking, "bank_max", math.inf) * DEGREES
    return [
        Reading(
            "Range", "m", float(np.linalg.norm(line)), error["range"],
            _limit(tracking, "distance_min", -math.inf),
        ),
        Reading("Altitude", "m", float(line[2]), error["altitude"], floor),
        Reading(
            "Airspeed", "m/s", sight.airspeed, error["speed"],
            _limit(tracking, "airspeed_min", -math.inf), _limit(tracking, "airspeed_max", math.inf),
        ),
        Reading("Bank", "°", sight.bank * DEGREES, math.nan, -bank, bank),
        Reading(
            "Path angle", "°", sight.path_angle * DEGREES, error["pitch"] * DEGREES,
            _limit(tracking, "path_angle_min", -math.inf) * DEGREES,
            _limit(tracking, "path_angle_max", math.inf) * DEGREES,
        ),
    ]  # fmt: skip


ERRORS = ("range", "altitude", "speed", "pitch")


def _limit(tracking: TrackingParameters | None, name: str, none: float) -> float:
    """A limit; one that is as wide as is allowed at all is none."""
    if tracking is None:
        return none
    value = float(getattr(tracking, name))
    return none if value in (KNOWN[name].lower, KNOWN[name].upper) else value


class Readings(PanelPart):
    """A table."""

    name = "readings"
    order = 10.0

    def add(self) -> None:
        """Begin with an empty one."""
        self._table = self.gui.add_html("")

    def show(self, sight: Sight) -> None:
        """Write the numbers of now.

        Args:
            sight: Of this aircraft.
        """
        rows = [_row(reading) for reading in readings(sight, self.flight.tracking)]
        self._table.content = block(table(rows, ("", "", "error", "limits")))


def _row(reading: Reading) -> list[str]:
    value = f"{number(reading.value, reading.digits)} {reading.unit}"
    if reading.mark:
        value = badge(value, ALARM if reading.mark.startswith("beyond") else ATTENTION)
    error = number(reading.error, reading.digits, signed=True)
    return [reading.name, f"<b>{value}</b>", error, faint(_limits(reading))]


def _limits(reading: Reading) -> str:
    low, high = math.isfinite(reading.least), math.isfinite(reading.most)
    least, most = number(reading.least, 0), number(reading.most, 0)
    if low and high:
        words = f"± {most}" if reading.least == -reading.most else f"{least} to {most}"
    else:
        words = f"from {least}" if low else f"to {most}" if high else ""
    return f"{reading.mark} {words}" if reading.mark else words
