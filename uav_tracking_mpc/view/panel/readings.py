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

"""Whether it is well; numbers with errors and limits; times of solves; plots of some minutes."""

from __future__ import annotations

import html
import math
from collections import deque
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.control.fallback import FallbackMode
from uav_tracking_mpc.limits import Cylinder
from uav_tracking_mpc.parameters.specification import specifications
from uav_tracking_mpc.settings.tracking import TrackingParameters
from uav_tracking_mpc.view.panel import FOLDED, PanelPart
from uav_tracking_mpc.view.panel._html import (
    ALARM,
    ATTENTION,
    CALM,
    badge,
    block,
    faint,
    gauge,
    number,
    table,
)
from uav_tracking_mpc.view.watched_flight import CONTROLLER, Sight, WatchedFlight

LATE = FallbackMode.FEASIBLE, FallbackMode.EARLIER_PLAN
AT_LIMIT = 0.02  # of what lies between the limits
DEGREES = math.degrees(1.0)
MARGIN = 1.0  # s; the flight may have gone on since it was seen
MINUTE = 60.0  # s
SPAN = 180.0  # s of the plots
RESOLUTION = 0.5  # s between their points
HEIGHT = 120  # pixels
BLUE, ORANGE, FALLBACK = "rgb(0,130,200)", "rgb(213,94,0)", "rgba(230,159,0,0.3)"
BANK = "Bank"
OF = {"Range": " to target", "Altitude": " over target"}  # where they are counted from
LEVEL = 0.05  # deg; a smaller bank is to neither side
LEAST_COST = 1e-6  # [-]; its logarithm is drawn
# About range error [m] and logarithm of the cost [-], so that what hardly changes looks so.
ROOM = 0.5
SPANNED = [("room", "transparent")] * 2
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
    """

    name: str
    unit: str
    value: float
    error: float = math.nan
    least: float = -math.inf
    most: float = math.inf

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
        Reading(BANK, "°", sight.bank * DEGREES, math.nan, -bank, bank),
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
    value = f"{number(reading.value)} {reading.unit}"
    if reading.name == BANK and abs(reading.value) >= LEVEL:
        side = "right" if reading.value > 0.0 else "left"
        value = f"{number(abs(reading.value))} {reading.unit} {side}"
    if reading.mark:
        value = badge(value, ALARM if reading.mark.startswith("beyond") else ATTENTION)
    error = number(reading.error, signed=True)
    name = reading.name + faint(OF.get(reading.name, ""))
    return [name, f"<b>{value}</b>", error, faint(_limits(reading))]


def _limits(reading: Reading) -> str:
    low, high = math.isfinite(reading.least), math.isfinite(reading.most)
    least, most = number(reading.least, 0), number(reading.most, 0)
    if low and high:
        words = f"± {most}" if reading.least == -reading.most else f"{least} to {most}"
    else:
        words = f"from {least}" if low else f"to {most}" if high else ""
    return f"{reading.mark} {words}" if reading.mark else words


def columns(
    flight: WatchedFlight, sight: Sight, span: float, read: Callable[[Sight], tuple[float, ...]]
) -> NDArray[np.float64]:
    """Times and figures of the past up to now, each a row of shape (n,), oldest first.

    Args:
        flight: What is read.
        sight: Of now.
        span: How far back in [s].
        read: Figures of a sight.
    """
    past = flight.past(span + MARGIN)
    seen = [each for each in past if sight.time - span <= each.time < sight.time]
    return np.array([(each.time, *read(each)) for each in (*seen, sight)]).T


class Timing(PanelPart):
    """Folded: late plans of the last minute, and times: now, median and 99th percentile."""

    name = "timing"
    order = 65.0
    period = 0.5

    def add(self) -> None:
        """Begin with an empty one."""
        self._late: deque[tuple[float, int]] = deque()  # times, and late plans since the start
        self._folder = self.gui.add_folder("Solver", order=FOLDED, expand_by_default=False)
        with self._folder:
            self._table = self.gui.add_html("")

    def show(self, sight: Sight) -> None:
        """Write the times of now and of the last minute.

        Args:
            sight: Of this aircraft.
        """
        _, *past = columns(self.flight, sight, MINUTE, lambda seen: (seen.solve_time, seen.latency))
        now = {"Solve time": sight.solve_time, "Latency": sight.latency}
        rows = [_times(name, now[name], each) for name, each in zip(now, past, strict=True)]
        self._table.content = block(table(rows, ("in ms, last minute", "now", "median", "p99")))
        late = self._late_plans(sight)
        words = f"{late} late plan{'s' if late > 1 else ''}" if late else "no late plan"
        self._folder.label = f"Solver: {words} in the last minute"

    def _late_plans(self, sight: Sight) -> int:
        """Plans of the last minute that were not finished in time, as the controller counts."""
        values = [status.values.get(f"mode {m.value}") for status in sight.statuses for m in LATE]
        counts, kept = [int(value) for value in values if value is not None], self._late
        if not counts:  # nobody has reported yet
            return 0
        if kept and (sight.time < kept[-1][0] or sum(counts) < kept[-1][1]):
            kept.clear()  # time, or the controller, began anew
        kept.append((sight.time, sum(counts)))
        while kept[0][0] < sight.time - MINUTE:
            kept.popleft()
        return kept[-1][1] - kept[0][1]


def _times(name: str, now: float, past: NDArray[np.float64]) -> list[str]:
    known = past[np.isfinite(past)]
    median, p99 = np.percentile(known, [50.0, 99.0]) if len(known) else (math.nan, math.nan)
    return [name, *(number(1e3 * float(value), 2) for value in (now, median, p99))]


class Plots(PanelPart):
    """Three plots over the time before now; what is shaded was flown by a fallback mode."""

    name = "plots"
    order = 60.0
    period = 0.5

    def add(self) -> None:
        """Add them; each appears with its first point."""
        with self.gui.add_folder(f"Last {SPAN:.0f} s", order=FOLDED, expand_by_default=False):
            self._range = self._plot("Range error [m]", [("range error", BLUE), *SPANNED])
            self._bank = self._plot(
                "Bank, right wing down [deg]",
                [("bank", BLUE), ("limit", ORANGE), ("limit", ORANGE)],
            )
            self._cost = self._plot("Cost, its power of ten", [("cost", BLUE), *SPANNED])

    def _plot(self, title: str, lines: list[tuple[str, str]]) -> Any:
        series: list[Any] = [{"label": "s"}]
        series += [{"label": "fallback", "scale": "mode", "fill": FALLBACK, "width": 0}]
        series += [
            {"label": label, "stroke": colour, "width": 1.5, "points": {"show": False}}
            for label, colour in lines
        ]
        scales: Any = {
            "x": {"time": False, "range": (-SPAN, 0.0)},
            "y": {},
            "mode": {"range": (0.0, 1.0)},
        }
        return self.gui.add_uplot(
            tuple(np.zeros(1) for _ in series),
            tuple(series),
            title=title,
            scales=scales,
            legend={"show": False},
            axes=({"size": 30, "ticks": {"show": False}}, {"size": 55, "ticks": {"show": False}}),
            height=HEIGHT,
            padding=(8, 12, 0, 0),
            visible=False,
        )

    def show(self, sight: Sight) -> None:
        """Draw what was seen.

        Args:
            sight: Of this aircraft.
        """
        rows = columns(self.flight, sight, SPAN, _figures)
        _, thinned = np.unique(np.floor(rows[0] / RESOLUTION), return_index=True)
        time, fallback, error, bank, cost = rows[:, thinned]
        time = time - sight.time
        tracking = self.flight.tracking
        limit = math.nan if tracking is None else math.degrees(tracking.bank_max)
        limits = np.full_like(bank, limit), np.full_like(bank, -limit)
        power = np.log10(np.maximum(cost, LEAST_COST))
        _draw(self._range, time, fallback, error, error - ROOM, error + ROOM)
        _draw(self._bank, time, fallback, bank, *limits)
        _draw(self._cost, time, fallback, power, power - ROOM, power + ROOM)


def _figures(seen: Sight) -> tuple[float, ...]:
    fallback = float(seen.mode is not None and not seen.mode.nominal)
    error = seen.errors.get("range_error", math.nan)
    return fallback, error, math.degrees(seen.bank), seen.cost


def _draw(
    plot: Any, time: NDArray[np.float64], fallback: NDArray[np.float64], *lines: NDArray[np.float64]
) -> None:
    """Points at which the first line is known; a plot without any does not appear."""
    known = np.isfinite(lines[0])
    plot.visible = bool(known.any())
    if plot.visible:
        plot.data = tuple(line[known] for line in (time, fallback, *lines))


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
        left, span = min(one.most - one.value, one.value - one.least), one.most - one.least
        if not math.isfinite(left):
            continue
        # Between two limits all is left in their middle; from one alone, where the value is 0.
        whole = one.value if math.isfinite(one.least) else one.most
        whole = 0.5 * span if math.isfinite(span) else max(whole, left)
        used = 1.0 - left / whole if whole > 0.0 else 1.0
        margins.append(_margin(one.name.lower(), f"{number(abs(left))} {one.unit}", left, used))
    limits = () if tracking is None else tracking.envelope.limits
    for limit in limits:
        for shape in limit.shapes:
            if isinstance(shape, Cylinder):
                away = math.hypot(*(sight.position[:2] - [shape.east, shape.north]))
                left = away - shape.radius if shape.outside else shape.radius - away
                used = shape.radius / max(away, 1e-9) if shape.outside else away / shape.radius
                margins.append(_margin(limit.label, f"{number(abs(left), 0)} m", left, used))
    return max(margins, key=lambda margin: margin.used, default=None)


def _margin(name: str, far: str, left: float, used: float) -> Margin:
    """Not "left", which after a bank is a side."""
    return Margin(f"{name}, {far} {'away' if left >= 0.0 else 'beyond'}", used)


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
    return Margin(f"target, known to ±{number(loose)} m", loose / (LOOSE * tracking.range))


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
