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

"""All channels of a flight: what they do, how sure that is, and what was seen of their limits.

How sure it is, is said by confidence intervals by the profile of the likelihood.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray
from scipy.optimize import brentq, minimize_scalar
from scipy.stats import chi2

from uav_tracking_mpc.report.figure_style import BLACK, BLUE, GREY, VERMILLION, drawing
from uav_tracking_mpc.report.pages import Table
from uav_tracking_mpc.settings.configuration import parameter_file
from uav_tracking_mpc.studies.identification.channel_fit import (
    DEAD_TIME_MAX,
    LAG_MAX,
    ChannelFit,
    Limits,
    Solved,
    limited_fit,
)
from uav_tracking_mpc.studies.identification.flight_record import (
    CHANNELS,
    PATH,
    SPEED,
    TURN,
    UNITS,
    ChannelRecord,
    read_bag_record,
    read_csv_record,
)
from uav_tracking_mpc.studies.study import Study

CONFIDENCE = 0.95  # -, confidence of the intervals
UNKNOWNS = 6  # that are fitted
FIRST_STEP = 0.01  # s, outwards from the best value
PRECISION = 2e-4  # s, tolerance of an interval's ends


class Estimate(NamedTuple):
    """A value and its confidence interval, all in the same unit.

    Attributes:
        value: The best, in [s] or [-].
        lower: End of the interval, in [s] or [-].
        upper: Its other end, in [s] or [-].
    """

    value: float
    lower: float
    upper: float


class Estimates(NamedTuple):
    """What is known of a channel.

    Attributes:
        lag: tau in [s].
        dead_time: D in [s].
        total: Their sum in [s]: by how much a slow demand is late.
        gain: G [-].
    """

    lag: Estimate
    dead_time: Estimate
    total: Estimate
    gain: Estimate


class Profile:
    """The misfit about the best fit; remembers every point that was tried."""

    def __init__(self, fit: ChannelFit) -> None:
        self._fit = fit
        self._tried: list[Solved] = [fit.solved]
        self._total = fit.lag + fit.dead_time

    def estimates(self) -> Estimates:
        """Best values and intervals."""
        fit = self._fit
        # Less than 1 where the noise is less than what is assumed at least.
        variance = max(fit.solved.misfit / (fit.count - UNKNOWNS), 1.0)
        self._allowed = fit.solved.misfit + variance * float(chi2.ppf(CONFIDENCE, 1))
        lag = self._interval(fit.lag, LAG_MAX, self._at_lag)
        dead_time = self._interval(fit.dead_time, DEAD_TIME_MAX, self._at_dead_time)
        total = self._interval(self._total, LAG_MAX + DEAD_TIME_MAX, self._at_total)
        return Estimates(lag, dead_time, total, self._gain())

    def _at_lag(self, lag: float) -> float:
        """Least misfit with this lag."""
        about = self._total - lag
        reach = 0.05 + abs(lag - self._fit.lag)
        return self._least(lambda dead_time: (lag, dead_time), about, reach, DEAD_TIME_MAX)

    def _at_dead_time(self, dead_time: float) -> float:
        about = self._total - dead_time
        reach = 0.05 + 2.0 * abs(dead_time - self._fit.dead_time)
        return self._least(lambda lag: (lag, dead_time), about, reach, LAG_MAX)

    def _at_total(self, total: float) -> float:
        about = self._fit.lag + (total - self._total)
        most = min(total, LAG_MAX)
        return self._least(lambda lag: (lag, max(total - lag, 0.0)), about, 0.5 * total, most)

    def _least(
        self, point: Callable[[float], tuple[float, float]], about: float, reach: float, most: float
    ) -> float:
        """Least misfit along a line of points, within the reach about a place on it."""
        low, high = max(about - reach, 0.0), min(max(about, 0.0) + reach, most)

        def misfit(place: float) -> float:
            solved = self._fit.solve(*point(float(place)))
            self._tried.append(solved)
            return solved.misfit

        if high - low < PRECISION:
            return misfit(low)
        found = minimize_scalar(
            misfit, bounds=(low, high), method="bounded", options={"xatol": PRECISION}
        )
        # The search never tries the ends themselves, where a lag or a dead time is 0.
        return float(min(found.fun, misfit(low))) if low == 0.0 else float(found.fun)

    def _interval(self, best: float, most: float, profile: Callable[[float], float]) -> Estimate:
        def excess(value: float) -> float:
            return profile(value) - self._allowed

        def end(direction: float) -> float:
            """Where the misfit comes to what is allowed; at the end of the range if it does not."""
            inside, step = best, FIRST_STEP
            while excess(outside := min(max(best + direction * step, 0.0), most)) <= 0.0:
                if outside in (0.0, most):
                    return outside
                inside, step = outside, 2.0 * step
            if excess(inside) >= 0.0:
                return inside
            return float(brentq(excess, *sorted((inside, outside)), xtol=PRECISION))

        return Estimate(best, end(-1.0), end(1.0))

    def _gain(self) -> Estimate:
        """Of all the points tried: those that line the region allowed are among them."""
        lower = upper = self._fit.solved.gain
        for solved in self._tried:
            room = self._allowed - solved.misfit
            if room > 0.0:
                reach = math.sqrt(room * solved.gain_variance)
                lower, upper = min(lower, solved.gain - reach), max(upper, solved.gain + reach)
        return Estimate(self._fit.solved.gain, lower, upper)


# Half of the interval of lag plus dead time up to which a channel counts as identified.
SURE, SURE_SHARE = 0.1, 0.25  # s, -: also as a share of the value


@dataclass(frozen=True)
class ChannelIdentification:
    """What a flight says of one channel.

    Attributes:
        name: Of the channel.
        estimates: Lag, dead time, their sum, and gain.
        fit: Where they come from.
        limits: What the answer shows of its limits.
    """

    name: str
    estimates: Estimates
    fit: ChannelFit
    limits: Limits

    @property
    def doubt(self) -> str:
        """Why the figures cannot be used, in words; empty if they can."""
        value, lower, upper = self.estimates.total
        if self.estimates.gain.upper < 0.0:
            return "answers the wrong way round: see the signs of the columns"
        sure = 0.5 * (upper - lower) <= max(SURE, SURE_SHARE * value)
        return "" if sure else "not sure, excite it more"

    @property
    def largest(self) -> tuple[float, float]:
        """Least and greatest rate flown in [rad/s] or [m/s^2]."""
        rate = self.fit.flown_rate()
        return float(np.min(rate)), float(np.max(rate))

    @property
    def observed_limits(self) -> tuple[float | None, float | None]:
        """Limits of what is flown in [rad/s], [m/s^2] or, of a turn, bank [rad]; None: unseen.

        Without an airspeed the limit of a turn tells of no bank.
        """
        if self.name == TURN and not self.fit.record.banks:
            return None, None
        gain = self.estimates.gain.value
        found = [float(gain * limit) if math.isfinite(limit) else None for limit in self.limits]
        if self.name == TURN:
            found = [None if tangent is None else math.atan(tangent) for tangent in found]
        return found[0], found[1]

    @property
    def largest_bank(self) -> float | None:
        """Greatest bank of the turns flown in [rad]; None of other channels, or if unknown."""
        record = self.fit.record
        if not record.banks:
            return None
        lever = np.interp(record.state.time, record.demand.time, record.leverage)
        return float(np.max(np.arctan(np.abs(self.fit.flown_rate() * lever))))

    def as_json(self) -> dict[str, Any]:
        """Plain values, in SI units and radians."""
        figures = {
            f"{name}{unit}": dict(zip(("value", "lower", "upper"), estimate, strict=True))
            for name, unit, estimate in zip(
                self.estimates._fields, ("_s", "_s", "_s", ""), self.estimates, strict=True
            )
        }
        return {
            **figures,
            "sure": not self.doubt,
            "largest": list(self.largest),
            "largest_bank_rad": self.largest_bank,
            "limits_observed": list(self.observed_limits),
            "noise": self.fit.noise[0].deviation,
            "noise_order": len(self.fit.noise[0].polynomial) - 1,
            "samples": self.fit.count,
        }


def identify(channels: Iterable[ChannelRecord]) -> list[ChannelIdentification]:
    """Identify channels of a flight, each by itself."""
    found = []
    for record in channels:
        fit, limits = limited_fit(record)
        found.append(ChannelIdentification(record.name, Profile(fit).estimates(), fit, limits))
    return found


def identification(path: Path) -> Study:
    """Every channel that a file holds: numbers, table, the YAML to paste and the figure.

    It is good if every channel was identified.

    Args:
        path: File, CSV by its ending, else a bag; or folder of a bag.

    Raises:
        ParameterError: It does not hold what is needed.
        OSError: It cannot be read.
    """
    record = read_csv_record(path) if path.suffix.lower() == ".csv" else read_bag_record(path)
    found = identify(record.channels())
    yaml = parameters_to_paste(found)
    content = {
        "record": str(path),
        "confidence": CONFIDENCE,
        "channels": {channel.name: channel.as_json() for channel in found},
        "yaml": yaml,
    }
    return Study(
        name="identification",
        content=content,
        words=[identification_table(found), yaml],
        written="figure: {}/response.png",
        figures={"response": partial(response_figure, found)},
        files={"identified.yaml": yaml.encode()},
        good=not any(channel.doubt for channel in found),
    )


HEADINGS = ("channel", "lag [s]", "dead time [s]", "sum [s]", "gain [-]", "flown", "limits seen")
# Parameters of a channel's limits, of controller and simulator; of a turn the bank.
LIMIT_NAMES = {
    TURN: ("bank_max",),
    PATH: ("pitch_rate_max",),
    SPEED: ("acceleration_min", "acceleration_max"),
}


def identification_table(found: Sequence[ChannelIdentification]) -> Table:
    """One row a channel."""
    return Table(
        HEADINGS,
        [_row(channel) for channel in found],
        title="How the aircraft answers commands",
        caption=f"In brackets: {CONFIDENCE:.0%} confidence intervals.",
    )


def _row(channel: ChannelIdentification) -> tuple[str, ...]:
    lag, dead_time, total, gain = channel.estimates
    least, greatest = channel.largest
    flown = f"{least:.2f} to {greatest:.2f} {UNITS[channel.name]}"
    bank = channel.largest_bank
    if bank is not None:
        flown += f", bank {math.degrees(bank):.0f} deg"
    limits = [_limit(channel.name, value) for value in channel.observed_limits if value is not None]
    name = f"{channel.name} (not sure)" if channel.doubt else channel.name
    figures = (_words(figure) for figure in (lag, dead_time, total, gain))
    return name, *figures, flown, ", ".join(limits) or "none"


def _words(estimate: Estimate) -> str:
    value, lower, upper = estimate
    return f"{value:.3f} [{lower:.3f}, {upper:.3f}]"


def _limit(name: str, value: float) -> str:
    if name == TURN:
        return f"bank {math.degrees(value):.0f} deg"
    return f"{value:.2f} {UNITS[name]}"


def parameters_to_paste(found: Sequence[ChannelIdentification]) -> str:
    """Sections of a configuration with what was identified, as YAML.

    A channel that was not identified keeps a comment; its numbers are placeholders.
    """
    known = {channel.name: channel for channel in found}
    answering = {name for name in known if known[name].estimates.gain.lower > 0.0}
    lag, dead_time, gain = (
        [
            round(getattr(known[name].estimates, figure).value, 3) if name in those else otherwise
            for name in CHANNELS
        ]
        for figure, otherwise, those in (
            ("lag", 0.0, known), ("dead_time", 0.0, known), ("gain", 1.0, answering)
        )
    )  # fmt: skip
    limits = {key: value for one in found for key, value in _limits_to_paste(one).items()}
    controller = {"rate_lag": lag, "dead_time": dead_time, **limits}
    # Lists of its own: YAML would refer to one that stands above.
    simulator = {"rate_lag": [*lag], "dead_time": [*dead_time], "command_gain": gain, **limits}
    doubts = {name: known[name].doubt if name in known else "not measured" for name in CHANNELS}
    comments = [f"# {name}: {words}\n" for name, words in doubts.items() if words]
    return "".join(comments) + parameter_file(
        {"nmpc_controller": controller, "uav_simulator": simulator}
    )


def _limits_to_paste(channel: ChannelIdentification) -> dict[str, float]:
    """Limits that showed, by parameter; of two sides of a symmetric one the smaller."""
    lower, upper = channel.observed_limits
    names = LIMIT_NAMES[channel.name]
    if len(names) == 2:
        pairs = zip(names, (lower, upper), strict=True)
        return {name: round(value, 3) for name, value in pairs if value is not None}
    sides = [abs(value) for value in (lower, upper) if value is not None]
    return {names[0]: round(min(sides), 3)} if sides else {}


WIDTH, ROW_HEIGHT, ROOM = 9.5, 2.5, 0.8  # inch
SHOWN = 30.0  # s of the end of the flight
ANGLE = 180.0 / np.pi  # deg per rad
# Title, unit of what was measured and of its rate, by what SI is multiplied for them.
PANELS = {
    TURN: ("Heading", "deg", "deg/s", ANGLE),
    PATH: ("Path angle", "deg", "deg/s", ANGLE),
    SPEED: ("Airspeed", "m/s", "m/s²", 1.0),
}


def response_figure(found: Sequence[ChannelIdentification]) -> Figure:
    """Left rates demanded and flown, right what was measured; both over the last 30 s."""
    with drawing(WIDTH, ROW_HEIGHT * len(found) + ROOM) as figure:
        rows = figure.subplots(len(found), 2, sharex=True, squeeze=False)
        for (left, right), channel in zip(rows, found, strict=True):
            _rates(left, channel)
            _measured(right, channel)
        for axes in rows[-1]:
            axes.set_xlabel("time [s]")
        end = max(float(channel.fit.record.state.time[-1]) for channel in found)
        rows[0][0].set_xlim(end - SHOWN, end)
        handles, labels = rows[0][0].get_legend_handles_labels()
        more = rows[0][1].get_legend_handles_labels()
        figure.legend(handles + more[0], labels + more[1], loc="upper center", ncols=4)
        top = 1.0 - 0.6 * ROOM / (ROW_HEIGHT * len(found) + ROOM)
        figure.tight_layout(rect=(0.0, 0.0, 1.0, top))
    return figure


def _shown(channel: ChannelIdentification) -> NDArray[np.bool_]:
    time = channel.fit.record.state.time
    return time >= time[-1] - SHOWN


def _rates(axes: Axes, channel: ChannelIdentification) -> None:
    """Demand and fitted rate; the measured one where there is any."""
    title, _, unit, scale = PANELS[channel.name]
    record, shown = channel.fit.record, _shown(channel)
    begin = record.state.time[-1] - SHOWN
    demand = record.demand
    late = demand.time >= begin
    axes.step(
        demand.time[late], scale * demand.value[late], where="post", color=GREY, lw=0.8,
        label="commanded",
    )  # fmt: skip
    if record.rate is not None:
        late = record.rate.time >= begin
        rate = record.rate.time[late], scale * record.rate.value[late]
        axes.plot(*rate, ".", ms=2.5, color=BLUE, label="_measured")
    axes.plot(
        record.state.time[shown], scale * channel.fit.flown_rate()[shown], color=VERMILLION,
        label="fitted rate",
    )  # fmt: skip
    axes.set(title=f"{title}: its rate", ylabel=f"[{unit}]")


def _measured(axes: Axes, channel: ChannelIdentification) -> None:
    """What was measured and what was fitted, less its mean slope."""
    title, unit, _, scale = PANELS[channel.name]
    record, shown = channel.fit.record, _shown(channel)
    time = record.state.time[shown]
    measured, fitted = record.state.value[shown], channel.fit.fitted()[shown]
    slope, level = np.polyfit(time - time[0], fitted, 1)
    trend = slope * (time - time[0]) + level
    axes.plot(time, scale * (measured - trend), ".", ms=2.5, color=BLUE, label="measured")
    axes.plot(time, scale * (fitted - trend), color=BLACK, lw=1.2, label="fitted")
    lag, dead_time, _, gain = channel.estimates
    axes.set(title=f"{title}, less its trend", ylabel=f"[{unit}]")
    axes.set_title(
        f"lag {lag.value:.2f} s, dead time {dead_time.value:.2f} s, gain {gain.value:.2f}",
        loc="right",
        fontsize=8,
        color=GREY,
    )
