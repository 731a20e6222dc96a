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

"""What must hold for every message that is sent to the autopilot."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable
from typing import Any

from uav_tracking_mpc.links.mavlink.connection import Connection
from uav_tracking_mpc.links.mavlink.dialect import mavlink

ROUNDING = math.radians(0.02)  # a bank is told in single precision, a limit in degrees
ROLL_IGNORED_AS_ATTITUDE = 0b10000000  # with which ArduPlane takes the axes one by one
FORBIDDEN = {
    mavlink.MAV_CMD_COMPONENT_ARM_DISARM: "arms or disarms",
    mavlink.MAV_CMD_NAV_TAKEOFF: "takes off",
    mavlink.MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN: "reboots",
}


class SentMessages:
    """Judges what goes out on a connection.

    Args:
        limits: Gives the autopilot's limits of now: bank, least and greatest pitch, in [rad], and
            thrust [-].
        commanding: Whether set-points may be sent now.

    Attributes:
        set_points: How many set-points were sent.
        broken: Of each rule how often it was broken, and how for the first time.
    """

    def __init__(
        self,
        limits: Callable[[], tuple[float, float, float, float, float]],
        commanding: Callable[[], bool],
    ) -> None:
        self._limits, self._commanding = limits, commanding
        self.set_points = 0
        self.broken: dict[str, str] = {}
        self._counts: Counter[str] = Counter()

    def take(self) -> dict[str, tuple[int, str]]:
        """What was broken since the last call: count and words by rule."""
        found = {name: (self._counts[name], words) for name, words in self.broken.items()}
        self.broken, self._counts = {}, Counter()
        return found

    def blame(self, rule: str, words: str) -> None:
        """Note that a rule was broken.

        Args:
            rule: Its name.
            words: How.
        """
        self._counts[rule] += 1
        self.broken.setdefault(rule, words)

    def watched(self, connection: Connection) -> Connection:
        """The connection, with everything that it sends looked at.

        Args:
            connection: Of the link.
        """
        send = connection.send

        def looked_at(message: Any) -> None:
            self._judge(message)
            send(message)

        connection.send = looked_at  # type: ignore[method-assign]
        return connection

    def _judge(self, message: Any) -> None:
        kind = message.get_type()
        numbers = [value for value in message.to_dict().values() if isinstance(value, float)]
        numbers += [float(value) for value in getattr(message, "q", ())]
        if not all(map(math.isfinite, numbers)):
            self.blame("finite", f"{kind} holds {message}")
        if kind == "SET_ATTITUDE_TARGET":
            self._judge_set_point(message)
        elif kind in ("PARAM_SET", "SET_MODE"):
            self.blame("harmless", f"{kind} was sent")
        elif kind in ("COMMAND_LONG", "COMMAND_INT") and message.command in FORBIDDEN:
            self.blame("harmless", f"a command that {FORBIDDEN[message.command]} was sent")

    def _judge_set_point(self, message: Any) -> None:
        self.set_points += 1
        if not self._commanding():
            self.blame("engaged", "a set-point was sent while nobody was engaged")
        bank_max, pitch_min, pitch_max, thrust_min, thrust_max = self._limits()
        w, x, y, z = message.q
        bank = math.atan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y))
        pitch = math.asin(max(-1.0, min(1.0, 2.0 * (w * y - z * x))))
        if abs(bank) > bank_max + ROUNDING:
            self.blame("bank", f"{math.degrees(bank):.1f} deg, may {math.degrees(bank_max):.1f}")
        if message.type_mask & ROLL_IGNORED_AS_ATTITUDE:
            return
        if not pitch_min - ROUNDING <= pitch <= pitch_max + ROUNDING:
            self.blame("pitch", f"{math.degrees(pitch):.1f} deg")
        if not thrust_min - 1e-6 <= message.thrust <= thrust_max + 1e-6:
            self.blame("thrust", f"{message.thrust:g}")
