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

"""What an autopilot answers to MAVLink messages, and what it tells unasked; no wire yet."""

from __future__ import annotations

import math
import struct
from collections.abc import Callable
from typing import Any

from uav_tracking_mpc.autopilot.autopilot_core import (
    AttitudeTarget,
    AutopilotCore,
    Cmd,
    Order,
    Result,
    Severity,
)
from uav_tracking_mpc.autopilot.flight_loops import TICK
from uav_tracking_mpc.autopilot.telemetry_messages import IDS, MessageRates, telemetry
from uav_tracking_mpc.dynamics.frames import bank_from_quaternion
from uav_tracking_mpc.links.mavlink.dialect import mavlink

COMPONENT = 1  # code MAV_COMP_ID_AUTOPILOT1
DEGREE = 1e-7  # deg, code: unit of latitude and longitude on the wire
TARGETED = ("target_system", "target_component")


class VehicleProtocol:
    """Speaks for one autopilot.

    Args:
        core: The autopilot.
        system: Its MAVLink system.

    Attributes:
        core: As above.
        system: As above.
        rates: Of its telemetry.
    """

    def __init__(self, core: AutopilotCore, system: int = 1) -> None:
        self.core, self.system = core, system
        self._next_sync = 0.0
        self._begin()

    def _begin(self) -> None:
        self.rates = MessageRates({"HEARTBEAT": 1.0, **self.core.traits.stream_rates})
        self._outgoing: list[Any] = []
        self._mode = self.core.mode

    def outgoing(self) -> list[Any]:
        """Messages to send now, in order; each is told once."""
        ready, self._outgoing = self._outgoing, []
        return ready

    def restart(self) -> None:
        """Boot anew in flight: clock, parameters, mode and rates are those of the start."""
        self.core.restart()
        self._begin()

    def advance(self, until: float) -> None:
        """Go on by whole ticks.

        Args:
            until: Time since the start in [s] that is not passed.
        """
        core = self.core
        while core.time + TICK <= until + 1e-9:
            core.step()
            for name in self.rates.due(core.time):
                self._send(telemetry(core, name))
            self._tell_changes()
            if core.time >= self._next_sync:
                self._next_sync = core.time + core.traits.sync_period
                self._send(mavlink.MAVLink_timesync_message(0, self._nanoseconds(core.time)))

    def take(self, message: Any, now: float) -> None:
        """Answer a message; one that is for somebody else is passed by.

        Args:
            message: As pymavlink has parsed it.
            now: When it came, since the start in [s].
        """
        if not self._for_us(message):
            return
        taker = _TAKERS.get(message.get_type())
        if taker is not None:
            taker(self, message, now)
            self._tell_changes()

    def _tell_changes(self) -> None:
        if self.core.mode != self._mode:
            self._mode = self.core.mode
            for name in self.core.traits.mode_messages:
                self._send(telemetry(self.core, name))
        for severity, words in self.core.texts:
            self._send(mavlink.MAVLink_statustext_message(severity, words.encode("ascii")))
        self.core.texts.clear()

    def _for_us(self, message: Any) -> bool:
        system, component = (getattr(message, name, 0) for name in TARGETED)
        if message.get_type() in ("COMMAND_LONG", "COMMAND_INT") and not self.core.traits.hears_all:
            return system == self.system and component in (0, COMPONENT)
        return system in (0, self.system) and component in (0, COMPONENT)

    def _send(self, message: Any) -> None:
        self._outgoing.append(message)

    def _nanoseconds(self, now: float) -> int:
        return round((now + self.core.clock_offset) * 1e9)

    def _take_heartbeat(self, message: Any, now: float) -> None:
        ground = message.type == mavlink.MAV_TYPE_GCS
        self.core.heard_heartbeat(message.get_srcSystem(), ground)

    def _take_sync(self, message: Any, now: float) -> None:
        if message.tc1 == 0:
            self._send(mavlink.MAVLink_timesync_message(self._nanoseconds(now), message.ts1))

    def _take_command(self, message: Any, now: float) -> None:
        """COMMAND_LONG, or COMMAND_INT with a place and its frame."""
        order = Order(
            message.command, message.param1, message.param2, message.param3, message.param4
        )
        if message.get_type() == "COMMAND_LONG":
            order = order._replace(x=message.param5, y=message.param6, z=message.param7)
        else:
            x, y = message.x * DEGREE, message.y * DEGREE
            order = order._replace(x=x, y=y, z=message.z, frame=message.frame)
        try:
            own = _COMMANDS.get(order.command)
            result = self.core.command(order) if own is None else own(self, order)
        except (ValueError, OverflowError):  # of int(nan): a number that means nothing
            result = Result.DENIED
        self._acknowledge(message, order.command, result)

    def _acknowledge(self, message: Any, command: int, result: int) -> None:
        self._send(
            mavlink.MAVLink_command_ack_message(
                command, result, 0, 0, message.get_srcSystem(), message.get_srcComponent()
            )
        )

    def _named(self, number: float) -> str | None:
        name = IDS.get(int(number))
        return None if name in self.core.traits.lacking else name

    def _interval(self, order: Order) -> int:
        """GCS_Common.cpp ``set_message_interval``; PX4: mavlink_receiver.cpp, same name."""
        name = self._named(order.param1)
        if name is None or not math.isfinite(order.param2):
            return Result.FAILED
        if order.param2 > 0.0:
            self.rates.ask(name, max(order.param2 * 1e-6, self.core.least_interval))
        else:
            self.rates.ask(name, 0.0 if order.param2 == 0.0 else -1.0)
        return Result.ACCEPTED

    def _request(self, order: Order) -> int:
        name = self._named(order.param1)
        return self.core.traits.unknown_message if name is None else self._tell(name)

    def _tell(self, name: str) -> int:
        self._send(telemetry(self.core, name))
        return Result.ACCEPTED

    def _take_mode(self, message: Any, now: float) -> None:
        """SET_MODE, the older message."""
        order = self.core.mode_order(message.base_mode, message.custom_mode)
        self._acknowledge(message, self.core.traits.set_mode_acknowledged, self.core.command(order))

    def _take_attitude(self, message: Any, now: float) -> None:
        w, x, y, z = message.q
        if not all(map(math.isfinite, (w, x, y, z, message.thrust))):
            return
        # Euler angles of a Forward-Right-Down body in North-East-Down, yaw first.
        roll = bank_from_quaternion(x, y, z, w)
        pitch = math.asin(min(max(2.0 * (w * y - z * x), -1.0), 1.0))
        thrust = min(max(message.thrust, 0.0), 1.0)
        self.core.attitude_target(AttitudeTarget(message.type_mask, roll, pitch, thrust))

    def _take_parameter_read(self, message: Any, now: float) -> None:
        names = list(self.core.parameters)
        if message.param_index >= 0:
            name = names[message.param_index] if message.param_index < len(names) else ""
        else:
            name = _text(message.param_id)
        if name in self.core.parameters:  # of others neither says a word
            self._send_parameter(name)

    def _take_parameter_list(self, message: Any, now: float) -> None:
        for name in self.core.parameters:
            self._send_parameter(name)

    def _take_parameter_set(self, message: Any, now: float) -> None:
        name, value = _text(message.param_id), float(message.param_value)
        known = self.core.parameters
        if name not in known:
            return
        if self.core.traits.bytewise and known.integer(name):
            (value,) = struct.unpack("<i", struct.pack("<f", value))
        if known.set(name, value):
            self._send_parameter(name)
        else:
            self.core.say(Severity.WARNING, f"Parameter {name} cannot be set")

    def _send_parameter(self, name: str) -> None:
        """PX4 puts the bytes of an integer into the float, ArduPilot its value."""
        known = self.core.parameters
        value, kind = float(known[name]), mavlink.MAV_PARAM_TYPE_REAL32
        if known.integer(name):
            kind = mavlink.MAV_PARAM_TYPE_INT32
            if self.core.traits.bytewise:
                (value,) = struct.unpack("<f", struct.pack("<i", int(known[name])))
        names = list(known)
        self._send(
            mavlink.MAVLink_param_value_message(
                name.encode("ascii"), value, kind, len(names), names.index(name)
            )
        )


def _text(words: str | bytes) -> str:
    """Name of a parameter as the wire has it, up to its first zero."""
    plain = words.decode("ascii", "replace") if isinstance(words, bytes) else words
    return plain.split("\0")[0]


_COMMANDS: dict[int, Callable[[VehicleProtocol, Order], int]] = {
    Cmd.SET_MESSAGE_INTERVAL: VehicleProtocol._interval,
    Cmd.REQUEST_MESSAGE: VehicleProtocol._request,
    Cmd.GET_HOME_POSITION: lambda protocol, order: protocol._tell("HOME_POSITION"),
    Cmd.REQUEST_AUTOPILOT_CAPABILITIES: lambda protocol, order: protocol._tell("AUTOPILOT_VERSION"),
}
_TAKERS: dict[str, Callable[[VehicleProtocol, Any, float], None]] = {
    "COMMAND_INT": VehicleProtocol._take_command,
    "COMMAND_LONG": VehicleProtocol._take_command,
    "HEARTBEAT": VehicleProtocol._take_heartbeat,
    "PARAM_REQUEST_LIST": VehicleProtocol._take_parameter_list,
    "PARAM_REQUEST_READ": VehicleProtocol._take_parameter_read,
    "PARAM_SET": VehicleProtocol._take_parameter_set,
    "SET_ATTITUDE_TARGET": VehicleProtocol._take_attitude,
    "SET_MODE": VehicleProtocol._take_mode,
    "TIMESYNC": VehicleProtocol._take_sync,
}
