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

"""A flight as its file tells: plans as they were flown, and what was measured of each channel.

Files are bags, and CSV files as ``simulate --excite`` writes them, or anybody.

A CSV file has named columns:

=========================  ======================================================
``time``                   in [s], of what the row holds
``turn_command``           u_psi [rad/s], demanded from that time on
``path_command``           u_chi [rad/s], likewise
``acceleration_command``   u_v [m/s^2], likewise
``heading``                psi [rad], counter-clockwise, wrapped or not
``path_angle``             chi [rad], positive up
``airspeed``               v [m/s]; may be missing
``turn_rate``              psi' [rad/s]; may be missing
``path_angle_rate``        chi' [rad/s]; may be missing
=========================  ======================================================

Other columns are ignored. A cell may be empty where a row holds commands only, or measurements
only. Where rows are missing, the longest time without such a gap counts. The time of a command is
when the aircraft got it, not that of the state it answers.

In a bag a command counts from when it was heard, by the clock of the stamps. Where a bag holds
``/clock``, that is the newest time heard before it; else bag and stamps must share a clock.
"""

from __future__ import annotations

import contextlib
import csv
import io
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from uav_tracking_mpc.control.command import Command
from uav_tracking_mpc.dynamics.air import GRAVITY
from uav_tracking_mpc.estimation.measurement import Measurement
from uav_tracking_mpc.nodes.messages.conversions import (
    measurement_from_odometry,
    nanoseconds,
    plan_from_command,
)
from uav_tracking_mpc.nodes.messages.heard_values import VALUES
from uav_tracking_mpc.nodes.topics import (
    AIR_VELOCITY,
    ANY_FRAMES,
    CLOCK,
    COMMAND,
    ODOMETRY,
    MessageError,
)
from uav_tracking_mpc.parameters.specification import ParameterError
from uav_tracking_mpc.report.atomic_write import write_atomically
from uav_tracking_mpc.report.bag import messages

TURN, PATH, SPEED = "turn", "path", "speed"
CHANNELS = (TURN, PATH, SPEED)  # in the order of (u_psi, u_chi, u_v)
UNITS = {TURN: "rad/s", PATH: "rad/s", SPEED: "m/s^2"}  # of what is demanded
WARM_UP = 5.0  # s after the first command, of which what came before it has no more part
SHORTEST = 10.0  # s of measurements, below which nothing can be said
FEWEST = 25  # measurements; with fewer their noise, of 16 coefficients at most, is not known
GAP = 2.0  # s without a row
GAP_SHARE = 10.0  # -, of the usual time between rows: what is longer than both is a gap
LAST_SEGMENT = 1.0  # s, of a plan that has one segment only
COMMANDS = ("turn_command", "path_command", "acceleration_command")
STATES = ("heading", "path_angle")
OPTIONAL = ("airspeed", "turn_rate", "path_angle_rate")
COLUMNS = ("time", *COMMANDS, *STATES, *OPTIONAL)
TOPICS = (ODOMETRY.name, AIR_VELOCITY.name, COMMAND.name, CLOCK.name)
APART = 10.0  # s by which bag and stamps may differ and still share a clock


class Samples(NamedTuple):
    """Values over time.

    Attributes:
        time: In [s], shape (n,), increasing.
        value: In the quantity's own unit, shape (n,), or (n, k) of k quantities.
    """

    time: NDArray[np.float64]
    value: NDArray[np.float64]

    def within(self, begin: float, end: float) -> Samples:
        """Those of a time from beginning to end, in [s]."""
        inside = (self.time >= begin) & (self.time <= end)
        return Samples(self.time[inside], self.value[inside])


@dataclass(frozen=True)
class ChannelRecord:
    """One channel over a flight.

    Attributes:
        name: One of :data:`CHANNELS`.
        demand: Rates demanded, each held until the next one.
        state: What the rate integrates to: heading (unwrapped), path angle or airspeed.
        rate: The rate itself, where it is measured.
        leverage: By what the demand is multiplied before it meets its limit, at each demand,
            shape (m,), in [s] or [-]: v / g in a turn, which banks by tan(bank) = v u_psi / g.
        banks: Whether it is: the airspeed of a turn is known.
    """

    name: str
    demand: Samples
    state: Samples
    rate: Samples | None
    leverage: NDArray[np.float64]
    banks: bool = False

    def between_commands(self) -> ChannelRecord:
        """The record without what was measured before or long after commands.

        Raises:
            ParameterError: There are too few measurements between commands.
        """
        span = self.demand.time[0] + WARM_UP, self.demand.time[-1] + 1.0
        kept = self.state.within(*span)
        length = kept.time[-1] - kept.time[0] if len(kept.time) else 0.0
        if not (length >= SHORTEST and len(kept.time) >= FEWEST):
            raise ParameterError(
                f"channel {self.name}: {len(kept.time)} measurements over {length:.1f} s with "
                f"commands, must be at least {FEWEST} over {SHORTEST:g} s beginning {WARM_UP:g} s "
                "after the first command"
            )
        return replace(self, state=kept, rate=_moving(self.rate and self.rate.within(*span)))


class FlownPlan(NamedTuple):
    """A plan as it came.

    Attributes:
        time: From which on it was flown, in [s]: when the aircraft got it.
        starts: When its segments begin, shape (n,), in [s].
        inputs: (u_psi, u_chi, u_v) of each, shape (n, 3), in [rad/s, rad/s, m/s^2].
    """

    time: float
    starts: NDArray[np.float64]
    inputs: NDArray[np.float64]

    @property
    def end(self) -> float:
        """When nothing is left of it, in [s]."""
        last = self.starts[-1] - self.starts[-2] if len(self.starts) > 1 else LAST_SEGMENT
        return float(self.starts[-1] + last)


def flown_demand(plans: Sequence[FlownPlan]) -> Samples:
    """What plans demanded over the longest time in which there was always one to fly.

    Args:
        plans: In the order in which they came.

    Returns:
        (u_psi, u_chi, u_v), each held until the next, in [rad/s, rad/s, m/s^2], shape (m, 3).

    Raises:
        ParameterError: There is none.
    """
    if not plans:
        raise ParameterError("there are no commands")
    stretches: list[list[FlownPlan]] = [[]]
    for plan in plans:
        if stretches[-1] and plan.time > stretches[-1][-1].end:
            stretches.append([])
        stretches[-1].append(plan)
    longest = max(stretches, key=lambda stretch: stretch[-1].time - stretch[0].time)
    times, inputs = [], []
    for plan, until in zip(longest, [*(p.time for p in longest[1:]), longest[-1].end], strict=True):
        first = max(int(np.searchsorted(plan.starts, plan.time, side="right")) - 1, 0)
        begins = np.maximum(plan.starts[first:], plan.time)
        flown = begins < until
        times.append(begins[flown])
        inputs.append(plan.inputs[first:][flown])
    return Samples(np.concatenate(times), np.concatenate(inputs))


@dataclass(frozen=True)
class FlightRecord:
    """A flight, as far as its file tells.

    Attributes:
        demand: What was commanded: (u_psi, u_chi, u_v), each held until the next.
        heading: psi, wrapped or not.
        path_angle: chi.
        airspeed: v; None where it was not measured.
        turn_rate: psi'; None where it was not measured.
        path_angle_rate: chi'; None where it was not measured.
    """

    demand: Samples
    heading: Samples
    path_angle: Samples
    airspeed: Samples | None = None
    turn_rate: Samples | None = None
    path_angle_rate: Samples | None = None

    def channels(self) -> list[ChannelRecord]:
        """Each channel that was measured.

        Raises:
            ParameterError: There are too few measurements.
        """
        time = self.demand.time
        turn, path, speed = (Samples(time, inputs) for inputs in self.demand.value.T)
        ones = np.ones_like(time)
        banks = self.airspeed is not None
        lateral = ones if self.airspeed is None else _smooth(time, self.airspeed) / GRAVITY
        heading = self.heading._replace(value=np.unwrap(self.heading.value))
        found = [
            ChannelRecord(TURN, turn, heading, self.turn_rate, lateral, banks),
            ChannelRecord(PATH, path, self.path_angle, self.path_angle_rate, ones),
        ]
        if self.airspeed is not None:
            found.append(ChannelRecord(SPEED, speed, self.airspeed, None, ones))
        return [channel.between_commands() for channel in found]


def samples(time: ArrayLike, values: ArrayLike) -> Samples:
    """Samples in order, one at a time, without what is no number.

    Args:
        time: In [s], in any order, shape (n,).
        values: Shape (n,).
    """
    times, held = np.asarray(time, dtype=float), np.asarray(values, dtype=float)
    known = np.isfinite(times) & np.isfinite(held)
    unique, first = np.unique(times[known], return_index=True)
    return Samples(unique, held[known][first])


def _moving(rate: Samples | None) -> Samples | None:
    """None for a rate that is hardly known, or never changes: its sender does not measure it."""
    known = rate is not None and len(rate.value) >= FEWEST and np.ptp(rate.value) > 0.0
    return rate if known else None


def _smooth(time: NDArray[np.float64], noisy: Samples) -> NDArray[np.float64]:
    """Means over a second, at other times, shape (n,)."""
    sums = np.concatenate([[0.0], np.cumsum(noisy.value)])
    first = np.searchsorted(noisy.time, time - 0.5)
    last = np.maximum(np.searchsorted(noisy.time, time + 0.5), first + 1)
    first, last = np.minimum(first, len(noisy.value) - 1), np.minimum(last, len(noisy.value))
    return (sums[last] - sums[first]) / np.maximum(last - first, 1)


class FlightWitness:
    """Sees a flight and keeps what a record of it needs.

    Attributes:
        plans: As the aircraft got them.
        measured: Of the aircraft, in the order in which it came.
        airspeeds: (time [s], v [m/s]), where they were measured.
    """

    def __init__(self) -> None:
        self.plans: list[FlownPlan] = []
        self.measured: list[Measurement] = []
        self.airspeeds: list[tuple[float, float]] = []

    def __call__(self, now: float, measured: Measurement, command: Command | None) -> None:
        """Take note of a tick: a ``Witness`` of the closed loop.

        Args:
            now: Time in [s].
            measured: What the sensors say.
            command: What the controller answers; None for nothing.
        """
        self.measured.append(measured)
        if measured.airspeed is not None:
            self.airspeeds.append((measured.stamp, measured.airspeed))
        if command is not None:
            starts = command.stamp + command.step * np.arange(float(len(command.inputs)))
            self.plans.append(FlownPlan(now, starts, command.inputs))

    def record(self) -> FlightRecord:
        """The flight so far.

        Raises:
            ParameterError: There was no command.
        """
        times = [measured.stamp for measured in self.measured]
        columns = {
            name: samples(times, [getattr(each, name) for each in self.measured])
            for name in (*STATES, "turn_rate", "path_angle_rate")
        }
        if self.airspeeds:
            columns["airspeed"] = samples(*zip(*self.airspeeds, strict=True))
        return FlightRecord(flown_demand(self.plans), **columns)


def write_record(record: FlightRecord, path: Path) -> None:
    """Write a record as CSV; the folder of the file is made."""
    columns: dict[str, Samples | None] = {
        name: Samples(record.demand.time, values)
        for name, values in zip(COMMANDS, record.demand.value.T, strict=True)
    }
    columns |= {name: getattr(record, name) for name in (*STATES, *OPTIONAL)}
    rows: dict[float, dict[str, float]] = {}
    for name, column in columns.items():
        if column is not None:
            for time, value in zip(column.time.tolist(), column.value.tolist(), strict=True):
                rows.setdefault(time, {})[name] = value
    text = io.StringIO()
    writer = csv.DictWriter(text, COLUMNS, restval="", lineterminator="\n")
    writer.writeheader()
    writer.writerows({"time": time, **rows[time]} for time in sorted(rows))
    path.parent.mkdir(parents=True, exist_ok=True)
    write_atomically(path, text.getvalue().encode())


def read_csv_record(path: Path) -> FlightRecord:
    """Read a CSV file with the columns above.

    Raises:
        ParameterError: A column is missing, a cell is no number, or there are no commands.
        OSError: It cannot be read.
    """
    # What is no UTF-8 may stand in columns that are not read.
    with path.open(newline="", encoding="utf-8-sig", errors="replace") as file:
        reader = csv.DictReader(file)
        reader.fieldnames = [name.strip() for name in reader.fieldnames or ()]
        missing = [name for name in COLUMNS if name not in (*reader.fieldnames, *OPTIONAL)]
        if missing:
            raise ParameterError(
                f"{path} has no columns {', '.join(missing)}; it must have "
                f"{', '.join(name for name in COLUMNS if name not in OPTIONAL)} and may have "
                f"{', '.join(OPTIONAL)}"
            )
        names = [name for name in COLUMNS if name in reader.fieldnames]
        rows = [
            [_number(row[name], f"{path}, line {reader.line_num}: {name}") for name in names]
            for row in reader
        ]
    whole = np.reshape(rows, (-1, len(names)))
    table = dict(zip(names, _longest_stretch(whole[np.isfinite(whole[:, 0])]).T, strict=True))
    time = table.pop("time")
    if np.any(np.abs(table["path_angle"]) > np.pi / 2.0):
        raise ParameterError(f"{path}: path_angle is beyond +-90 deg, must be in rad")
    inputs = np.column_stack([table.pop(name) for name in COMMANDS])
    commanded = np.isfinite(inputs).all(axis=1)
    if not commanded.any():
        raise ParameterError(f"{path} holds no command")
    columns = {
        name: samples(time, values)
        for name, values in table.items()
        if name in STATES or np.isfinite(values).any()
    }
    return FlightRecord(Samples(time[commanded], inputs[commanded]), **columns)


def _longest_stretch(rows: NDArray[np.float64]) -> NDArray[np.float64]:
    """Rows by their time, the first column, over the longest time without a gap in the record."""
    rows = rows[np.argsort(rows[:, 0], kind="stable")]
    steps = np.diff(rows[:, 0])
    usual = np.median(steps[steps > 0.0]) if np.any(steps > 0.0) else 0.0
    parts = np.split(rows, 1 + np.flatnonzero(steps > max(GAP_SHARE * usual, GAP)))
    return max(parts, key=lambda part: part[-1, 0] - part[0, 0] if len(part) else 0.0)


def _number(cell: str | None, where: str) -> float:
    """What a cell holds; nan where it is empty."""
    text = (cell or "").strip()
    try:
        return float(text or np.nan)
    except ValueError:
        raise ParameterError(f"{where} is {text!r}, must be a number or empty") from None


def read_bag_record(path: Path) -> FlightRecord:
    """Read a bag; messages that cannot be used are left out.

    Args:
        path: A file ``.mcap``, or the folder of a bag.

    Raises:
        ParameterError: It is no bag, or does not hold commands and states.
    """
    witness = FlightWitness()
    origin, clock = None, None  # [ns]
    for topic, heard, message in messages(path, TOPICS):
        if topic == CLOCK.name:
            clock = nanoseconds(message.clock)
            continue
        stamp = nanoseconds(message.header.stamp)
        origin = stamp if origin is None else origin
        time = (stamp - origin) * 1e-9  # as floats, whole times would lose nanoseconds
        with contextlib.suppress(MessageError):
            if topic == ODOMETRY.name:
                witness.measured.append(measurement_from_odometry(message, time, ANY_FRAMES))
            elif topic == AIR_VELOCITY.name:
                witness.airspeeds.append((time, VALUES[topic](message)))
            else:
                inputs, starts = plan_from_command(message, ANY_FRAMES)
                late = _lateness(stamp, heard if clock is None else clock)
                witness.plans.append(FlownPlan(time + late, time + starts, inputs))
    for found, name in ((witness.measured, ODOMETRY.name), (witness.plans, COMMAND.name)):
        if not found:
            raise ParameterError(f"bag {path} holds no {name}")
    return witness.record()


def _lateness(stamp: int, heard: int) -> float:
    """Time in [s] from the stamp of a command in [ns] to when it was heard in [ns]."""
    late = (heard - stamp) * 1e-9
    if not abs(late) <= APART:
        raise ParameterError(
            f"a command was heard {late:.3g} s after its stamp, may be {APART:g} s: bag and "
            "stamps do not share a clock; record /clock with simulated time"
        )
    # A clock that stands between its ticks may be older than the stamp of a state just heard.
    return max(late, 0.0)
