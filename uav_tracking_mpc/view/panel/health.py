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

"""Is it well: one line in words, the margin to the nearest limit, the sensor that is worst."""

from __future__ import annotations

import html
import math
from typing import NamedTuple

import numpy as np

from uav_tracking_mpc.control.fallback import FallbackMode
from uav_tracking_mpc.limits import Cylinder
from uav_tracking_mpc.settings.tracking import TrackingParameters
from uav_tracking_mpc.view.panel import PanelPart
from uav_tracking_mpc.view.panel._html import ALARM, ATTENTION, CALM, block, gauge, number
from uav_tracking_mpc.view.panel.readings import readings
from uav_tracking_mpc.view.watched_flight import CONTROLLER, Sight

ON_ORBIT = 0.03  # by the range: a smaller error of range and altitude is being on the orbit
NEAR, AT = 0.85, 0.98  # share of a limit that is used up from which on it is near, and reached
SIGMAS = 3.0
LOOSE = 0.1  # by the range: three standard deviations of a target that is hardly known
SENSOR = " sensor"  # how values of the controller end that say whether a sensor is used
USED = "used"
WORDS = {
    FallbackMode.GUIDANCE_LAW: "is flown by a guidance law, as asked",
    FallbackMode.FEASIBLE: "flies plans that are safe, but cut short for time",
    FallbackMode.EARLIER_PLAN: "lives on an earlier plan",
    FallbackMode.LOITER: "circles by the loiter law, without a plan",
    FallbackMode.HOLD: "holds its wings level and waits",
    FallbackMode.SILENCE: "gets no commands",
    None: "waits for its first command",
}


class Margin(NamedTuple):
    """How much of something is used up.

    Attributes:
        words: What, and how much of it.
        used: Share of it, 1 where nothing is left [-].
    """

    words: str
    used: float


def in_words(sight: Sight, tracking: TrackingParameters | None) -> str:
    """Whether it is well, in one line.

    Args:
        sight: Of the aircraft.
        tracking: What its controller flies by; None where that is not known.
    """
    if sight.mode is not FallbackMode.OPTIMAL:
        words = WORDS[sight.mode]
        calm = sight.mode in (FallbackMode.GUIDANCE_LAW, FallbackMode.FEASIBLE)
        return words if calm or not sight.reason else f"{words}: {sight.reason}"
    error = sight.errors.get("range_error", math.nan)
    if tracking is None or not math.isfinite(error):
        return "flies the best plan"
    height = sight.errors.get("altitude_error", 0.0)
    away = math.hypot(error, height if math.isfinite(height) else 0.0)
    if away > ON_ORBIT * tracking.range:
        return f"on its way to the orbit: {number(away, 0)} m to go"
    return "well: it is on the orbit"


def nearest_limit(sight: Sight, tracking: TrackingParameters | None) -> Margin | None:
    """The limit of which most is used up; None where there is none.

    Args:
        sight: Of the aircraft.
        tracking: What its controller flies by; None where that is not known.
    """
    margins = []
    for one in readings(sight, tracking):
        low, high = math.isfinite(one.least), math.isfinite(one.most)
        if not math.isfinite(one.value) or not (low or high):
            continue
        if low and high:
            half = 0.5 * (one.most - one.least)
            used = abs(one.value - 0.5 * (one.most + one.least)) / half
            left = min(one.most - one.value, one.value - one.least)
        else:  # a least distance or height
            used = one.least / max(one.value, 1e-9) if one.least > 0.0 else 0.0
            left = one.value - one.least
        margins.append(Margin(f"{one.name.lower()}, {number(left)} {one.unit} left", used))
    limits = () if tracking is None else tracking.envelope.limits
    for limit in limits:
        for shape in limit.shapes:
            if isinstance(shape, Cylinder):
                away = math.hypot(*(sight.position[:2] - [shape.east, shape.north]))
                used = shape.radius / max(away, 1e-9) if shape.outside else away / shape.radius
                words = f"{limit.label}, {number(abs(shape.radius - away), 0)} m left"
                margins.append(Margin(words, used))
    return max(margins, key=lambda margin: margin.used, default=None)


def worst_sensor(sight: Sight, tracking: TrackingParameters | None) -> Margin | None:
    """The sensor that is left out, else how surely the target is known; None for unknown.

    Args:
        sight: Of the aircraft.
        tracking: What its controller flies by; None where that is not known.
    """
    for status in sight.statuses:
        if status.node.rpartition("/")[2] != CONTROLLER:
            continue
        for key, state in status.values.items():
            if key.endswith(SENSOR) and state != USED:
                return Margin(f"{key.removesuffix(SENSOR)}: {state}, left out", 1.0)
    if sight.target is None:
        return Margin("target: not seen yet", 1.0)
    if not math.isfinite(sight.target.std) or tracking is None:
        return None
    loose = SIGMAS * sight.target.std
    measured = sight.target.measured
    if measured is None or not np.isfinite(measured).all():
        return None
    return Margin(f"target, to {number(loose)} m", loose / (LOOSE * tracking.range))


class Health(PanelPart):
    """One line, and two gauges."""

    name = "health"
    order = 6.0

    def add(self) -> None:
        """Begin with nothing."""
        self._shown = self.gui.add_html("")

    def show(self, sight: Sight) -> None:
        """Write how it is now.

        Args:
            sight: Of this aircraft.
        """
        tracking = self.flight.tracking
        rows = [f"<b>{html.escape(in_words(sight, tracking))}</b>"]
        for name, margin in (
            ("nearest limit", nearest_limit(sight, tracking)),
            ("worst sensor", worst_sensor(sight, tracking)),
        ):
            if margin is not None:
                colour = ALARM if margin.used > AT else ATTENTION if margin.used > NEAR else CALM
                rows.append(gauge(f"{name}: {margin.words}", margin.used, colour))
        self._shown.content = block(*rows)
