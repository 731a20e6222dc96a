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

"""Commands to the autopilot, sent again until they are acknowledged; every answer is reported.

MAVLink guide, Command Protocol: a command that is not acknowledged in time is repeated with its
``confirmation`` counted up; IN_PROGRESS puts the end off.

Parameters are read by name and never written.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Container, Iterable
from dataclasses import dataclass
from typing import Any

from uav_tracking_mpc.control.event import EventLog, Level
from uav_tracking_mpc.links.mavlink.connection import Connection
from uav_tracking_mpc.links.mavlink.dialect import mavlink, name_of

WAIT = 0.7  # s for an acknowledgement
ATTEMPTS = 4  # of a command that is not acknowledged
PROGRESS = 10.0  # s that an autopilot may be at it
NOT_ANSWERED = "not answered"  # as the answer to a request


def long_command(system: int, command: int, *parameters: float) -> Any:
    """A COMMAND_LONG to an autopilot.

    Args:
        system: MAVLink system of the autopilot.
        command: Of MAV_CMD.
        parameters: Its parameters, up to seven, in the command's units [SI]; the rest is 0.
    """
    values = (*parameters, *[0.0] * (7 - len(parameters)))
    return mavlink.MAVLink_command_long_message(system, 1, command, 0, *values)


@dataclass
class _Request:
    message: Any
    words: str
    quiet: bool
    due: float
    attempts: int = 1


class Requests:
    """Commands under way: one of each kind, a newer one takes the place of the older.

    Args:
        connection: To the autopilot.
        events: Where answers are reported.

    Attributes:
        system: MAVLink system of the autopilot.
        refused: How many commands were refused or never answered.
    """

    def __init__(self, connection: Connection, events: EventLog) -> None:
        self.system = 0
        self.refused = 0
        self._connection, self._events = connection, events
        self._pending: dict[int, _Request] = {}
        self._results: dict[int, str] = {}

    def ask(self, now: float, command: int, words: str, *parameters: float) -> None:
        """Send a COMMAND_LONG.

        Args:
            now: Our time in [s].
            command: Of MAV_CMD.
            words: What it asks for, for people.
            parameters: As of :func:`long_command`.
        """
        message = long_command(self.system, command, *parameters)
        self._send(now, command, message, words, quiet=False)

    def ask_there(
        self,
        now: float,
        command: int,
        words: str,
        parameters: tuple[float, float, float, float],
        place: tuple[int, int, float],
        quiet: bool = False,
    ) -> None:
        """Send a COMMAND_INT, which keeps the digits of a place; altitudes are above sea level.

        Args:
            now: Our time in [s].
            command: Of MAV_CMD.
            words: What it asks for, for people.
            parameters: Its first four parameters, in the units of the command [SI].
            place: Latitude and longitude in units of 1e-7 deg, altitude in [m].
            quiet: Whether only a refusal is reported.
        """
        message = mavlink.MAVLink_command_int_message(
            self.system, 1, mavlink.MAV_FRAME_GLOBAL, command, 0, 0, *parameters, *place
        )
        self._send(now, command, message, words, quiet)

    def _send(self, now: float, command: int, message: Any, words: str, quiet: bool) -> None:
        self._pending[command] = _Request(message, words, quiet, now + WAIT)
        self._results.pop(command, None)
        self._connection.send(message)

    def result(self, command: int) -> str | None:
        """Answer to the newest request of a kind, such as ACCEPTED; None while it waits.

        Args:
            command: Of MAV_CMD.
        """
        return self._results.get(command)

    def drop(self) -> None:
        """Ask for nothing of what is under way any more."""
        self._pending.clear()

    def see(self, message: Any, now: float) -> None:
        """Take in a COMMAND_ACK.

        Args:
            message: Of the autopilot.
            now: Our time in [s].
        """
        request = self._pending.get(message.command)
        if request is None:
            return
        if message.result == mavlink.MAV_RESULT_IN_PROGRESS:
            request.due = now + PROGRESS
            return
        self._end(message.command, name_of("MAV_RESULT", message.result))

    def tend(self, now: float) -> None:
        """Repeat what was not answered in time; give up after some attempts.

        Args:
            now: Our time in [s].
        """
        for command, request in list(self._pending.items()):
            if now < request.due:
                continue
            if request.attempts == ATTEMPTS:
                self._end(command, NOT_ANSWERED)
                continue
            request.attempts, request.due = request.attempts + 1, now + WAIT
            if hasattr(request.message, "confirmation"):
                request.message.confirmation = request.attempts - 1
            self._connection.send(request.message)

    def _end(self, command: int, result: str) -> None:
        request = self._pending.pop(command)
        self._results[command] = result
        if result != "ACCEPTED":
            self.refused += 1
            self._events.add(Level.WARNING, f"the autopilot refused {request.words}: {result}")
        elif not request.quiet:
            self._events.add(Level.INFO, f"the autopilot accepted {request.words}")


ROUND = 0.4  # s of waiting for answers before what is missing is asked for again
ROUNDS = 5  # an autopilot answers nothing where it has no parameter of that name
_INTEGERS = {  # how PX4 puts integers into the float of PARAM_VALUE: bit by bit
    mavlink.MAV_PARAM_TYPE_INT8: "<b",
    mavlink.MAV_PARAM_TYPE_UINT8: "<B",
    mavlink.MAV_PARAM_TYPE_INT16: "<h",
    mavlink.MAV_PARAM_TYPE_UINT16: "<H",
    mavlink.MAV_PARAM_TYPE_INT32: "<i",
    mavlink.MAV_PARAM_TYPE_UINT32: "<I",
}


def value_of(message: Any, by_bits: bool) -> float:
    """Value of a PARAM_VALUE, in the parameter's own unit.

    Args:
        message: PARAM_VALUE.
        by_bits: Whether integers travel bit by bit (MAV_PROTOCOL_CAPABILITY_PARAM_ENCODE_BYTEWISE).
    """
    form = _INTEGERS.get(message.param_type) if by_bits else None
    if form is None:
        return float(message.param_value)
    return float(struct.unpack_from(form, struct.pack("<f", message.param_value))[0])


def ask_for_parameters(
    connection: Connection,
    system: int,
    names: Iterable[str],
    known: Container[str],
    receive: Callable[[float], object],
) -> None:
    """Ask for parameters by name, until those are known that the autopilot has.

    Args:
        connection: To the autopilot.
        system: Its MAVLink system.
        names: Which to ask for.
        known: Names of those that have come.
        receive: Takes in the autopilot's messages of the next so many seconds, or earlier.
    """
    for _ in range(ROUNDS):
        missing = [name for name in names if name not in known]
        for name in missing:
            connection.send(
                mavlink.MAVLink_param_request_read_message(system, 1, name.encode("ascii"), -1)
            )
        end = connection.now() + ROUND
        while (left := end - connection.now()) > 0.0 and any(n not in known for n in missing):
            receive(left)
