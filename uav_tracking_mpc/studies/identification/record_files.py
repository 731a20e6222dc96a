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

"""Recorded flights: bags, and CSV files as ``simulate --excite`` writes them, or anybody.

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
only. The time of a command is when the aircraft got it, not that of the state it answers.

In a bag a command counts from when it was heard, by the clock of the stamps. Where a bag holds
``/clock``, that is the newest time heard before it; else bag and stamps must share a clock.
"""

from __future__ import annotations

import csv
import io
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.control.command import Command
from uav_tracking_mpc.dynamics.frames import (
    course_from_quaternion,
    course_rates,
    pitch_rate_from_path_angle_rate,
    rotation_from_quaternion,
)
from uav_tracking_mpc.estimation.measurement import Measurement
from uav_tracking_mpc.nodes.messages.conversions import nanoseconds
from uav_tracking_mpc.nodes.topics import AIR_VELOCITY, CLOCK, COMMAND, ODOMETRY
from uav_tracking_mpc.report.atomic_write import write_atomically
from uav_tracking_mpc.report.bag import BagError, messages
from uav_tracking_mpc.studies.identification.flight_record import (
    Demand,
    FlightRecord,
    FlownPlan,
    RecordError,
    Samples,
    flown_demand,
    samples,
)

COMMANDS = ("turn_command", "path_command", "acceleration_command")
STATES = ("heading", "path_angle")
OPTIONAL = ("airspeed", "turn_rate", "path_angle_rate")
COLUMNS = ("time", *COMMANDS, *STATES, *OPTIONAL)


class FlightWitness:
    """Sees a simulated flight and keeps what a record of it needs."""

    def __init__(self) -> None:
        self._plans: list[FlownPlan] = []
        self._measured: list[Measurement] = []

    def __call__(self, now: float, measured: Measurement, command: Command | None) -> None:
        """Take note of a tick: a ``Witness`` of the closed loop.

        Args:
            now: Time in [s].
            measured: What the sensors say.
            command: What the controller answers; None for nothing.
        """
        self._measured.append(measured)
        if command is not None:
            starts = command.stamp + command.step * np.arange(float(len(command.inputs)))
            self._plans.append(FlownPlan(now, starts, command.inputs))

    def record(self) -> FlightRecord:
        """The flight so far.

        Raises:
            RecordError: There was no command.
        """
        times = [measured.stamp for measured in self._measured]

        def column(name: str) -> Samples:
            values = [getattr(measured, name) for measured in self._measured]
            return samples(times, [np.nan if value is None else value for value in values])

        heading, path_angle = (column(name) for name in STATES)
        airspeed, turn_rate, path_angle_rate = (column(name) for name in OPTIONAL)
        demand = flown_demand(self._plans)
        return FlightRecord(demand, heading, path_angle, airspeed, turn_rate, path_angle_rate)


def write_record(record: FlightRecord, path: Path) -> None:
    """Write a record as CSV.

    Args:
        record: Of a flight.
        path: The file; its folder is made.
    """
    columns = dict(zip(COMMANDS, record.demand.inputs.T, strict=True))
    rows: dict[float, dict[str, float]] = {}
    for name, values in columns.items():
        _fill(rows, name, Samples(record.demand.time, values))
    for name in (*STATES, *OPTIONAL):
        values = getattr(record, name)
        if values is not None:
            _fill(rows, name, values)
    text = io.StringIO()
    writer = csv.DictWriter(text, COLUMNS, restval="", lineterminator="\n")
    writer.writeheader()
    writer.writerows({"time": time, **rows[time]} for time in sorted(rows))
    path.parent.mkdir(parents=True, exist_ok=True)
    write_atomically(path, text.getvalue().encode())


def _fill(rows: dict[float, dict[str, float]], name: str, column: Samples) -> None:
    for time, value in zip(column.time.tolist(), column.value.tolist(), strict=True):
        rows.setdefault(time, {})[name] = value


def read_csv_record(path: Path) -> FlightRecord:
    """Read a CSV file with the columns above.

    Args:
        path: The file.

    Raises:
        RecordError: A column is missing, a cell is no number, or there are no commands.
        OSError: It cannot be read.
    """
    with path.open(newline="", encoding="utf-8-sig") as file:
        reader = csv.DictReader(file)
        names = [name.strip() for name in reader.fieldnames or ()]
        missing = [name for name in COLUMNS if name not in (*names, *OPTIONAL)]
        if missing:
            raise RecordError(
                f"{path} has no columns {', '.join(missing)}; it must have "
                f"{', '.join(name for name in COLUMNS if name not in OPTIONAL)} and may have "
                f"{', '.join(OPTIONAL)}"
            )
        reader.fieldnames = names
        table = _table(path, reader, [name for name in COLUMNS if name in names])
    time = table["time"]
    inputs = np.column_stack([table[name] for name in COMMANDS])
    commanded = np.isfinite(inputs).all(axis=1) & np.isfinite(time)
    if not commanded.any():
        raise RecordError(f"{path} holds no command")
    order = np.argsort(time[commanded], kind="stable")
    demand = Demand(time[commanded][order], inputs[commanded][order])
    heading, path_angle = (samples(time, table[name]) for name in STATES)
    airspeed, turn_rate, path_angle_rate = (
        samples(time, table[name]) if name in table and np.isfinite(table[name]).any() else None
        for name in OPTIONAL
    )
    return FlightRecord(demand, heading, path_angle, airspeed, turn_rate, path_angle_rate)


def _table(
    path: Path, reader: csv.DictReader[str], names: list[str]
) -> dict[str, NDArray[np.float64]]:
    """Columns by name, shape (n,) each; an empty cell is nan."""
    columns: dict[str, list[float]] = {name: [] for name in names}
    for row in reader:
        for name in names:
            text = (row[name] or "").strip()
            try:
                columns[name].append(float(text) if text else np.nan)
            except ValueError:
                raise RecordError(
                    f"{path}, line {reader.line_num}: {name} is {text!r}, must be a number or empty"
                ) from None
    return {name: np.array(values) for name, values in columns.items()}


TOPICS = (ODOMETRY.name, AIR_VELOCITY.name, COMMAND.name, CLOCK.name)
APART = 10.0  # s by which bag and stamps may differ and still share a clock


class _Contents:
    """Columns, message by message; times in [ns] by the clock of the stamps."""

    def __init__(self) -> None:
        self.plans: list[FlownPlan] = []
        self.states: list[tuple[float, ...]] = []  # time, psi, chi, psi', chi'
        self.airspeeds: list[tuple[float, float]] = []
        self.origin: int | None = None
        self.clock: int | None = None

    def since(self, time: int) -> float:
        """Time since the first stamp in [s]: as floats, whole times would lose nanoseconds."""
        if self.origin is None:
            self.origin = time
        return (time - self.origin) * 1e-9

    def take(self, topic: str, heard: int, message: Any) -> None:
        if topic == CLOCK.name:
            self.clock = nanoseconds(message.clock)
            return
        stamp = nanoseconds(message.header.stamp)
        if topic == ODOMETRY.name:
            self.states.append((self.since(stamp), *_course(message)))
        elif topic == AIR_VELOCITY.name:
            linear = message.twist.linear
            speed = float(np.linalg.norm([linear.x, linear.y, linear.z]))
            self.airspeeds.append((self.since(stamp), speed))
        else:
            self._command(stamp, heard if self.clock is None else self.clock, message)

    def _command(self, stamp: int, heard: int, message: Any) -> None:
        late = (heard - stamp) * 1e-9
        if not abs(late) <= APART:
            raise RecordError(
                f"a command was heard {late:.3g} s after its stamp, may be {APART:g} s: bag and "
                "stamps do not share a clock; record /clock with simulated time"
            )
        inputs, starts = [], []
        for point in message.points:
            angular, linear = point.velocities[0].angular, point.accelerations[0].linear
            inputs.append((angular.z, pitch_rate_from_path_angle_rate(angular.y), linear.x))
            starts.append(self.since(stamp + nanoseconds(point.time_from_start)))
        # A clock that stands between its ticks may be older than the stamp of a state just heard.
        time = self.since(max(heard, stamp))
        self.plans.append(FlownPlan(time, np.array(starts), np.array(inputs)))


def read_bag_record(path: Path) -> FlightRecord:
    """Read a bag.

    Args:
        path: A file ``.mcap``, or the folder of a bag.

    Raises:
        RecordError: It is no bag, or does not hold commands and states.
    """
    contents = _Contents()
    try:
        for topic, heard, message in messages(path, TOPICS):
            contents.take(topic, heard, message)
    except BagError as error:
        raise RecordError(str(error)) from error
    if not contents.states:
        raise RecordError(f"bag {path} holds no {ODOMETRY.name}")
    if not contents.plans:
        raise RecordError(f"bag {path} holds no {COMMAND.name}")
    time, *columns = zip(*contents.states, strict=True)
    heading, path_angle, turn_rate, path_angle_rate = (samples(time, column) for column in columns)
    airspeed: Samples | None = None
    if contents.airspeeds:
        airspeed = samples(*zip(*contents.airspeeds, strict=True))
    return FlightRecord(
        flown_demand(contents.plans), heading, path_angle, airspeed, turn_rate, path_angle_rate
    )


def _course(message: Any) -> tuple[float, float, float, float]:
    """(psi, chi, psi', chi') of an Odometry message, in [rad] and [rad/s]."""
    q, angular = message.pose.pose.orientation, message.twist.twist.angular
    heading, path_angle = course_from_quaternion(q.x, q.y, q.z, q.w)
    rotation = rotation_from_quaternion(q.x, q.y, q.z, q.w)
    turn_rate, path_angle_rate = course_rates(rotation, (angular.x, angular.y, angular.z))
    return heading, path_angle, turn_rate, path_angle_rate
