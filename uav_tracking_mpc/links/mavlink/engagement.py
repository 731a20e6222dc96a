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

"""Who flies: the pilot and the autopilot, or our commands.

Nothing is commanded unless somebody engaged. From then on the autopilot's mode says who flies: its
mode of external commands, and it is us; any other, and our commands end with the message that tells
so, until somebody engages again. A pilot who changes the mode while we still ask for ours ends the
asking. One thing is told apart: an autopilot that lost us goes into a failsafe of its own and says
so (MAV_STATE_CRITICAL). If nothing was heard of it before, the link was dead, and when it takes
external commands up again by itself, ours go on.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from enum import Enum

from uav_tracking_mpc.control.event import EventLog, Level

SILENCE = 0.7  # s without a message, after which a failsafe is put down to the dead link
PATIENCE = 6.0  # s for the autopilot to change its mode


class State(Enum):
    """Who flies."""

    IDLE = "idle"
    ASKING = "asking"
    ENGAGED = "engaged"
    SUSPENDED = "suspended"


class Engagement:
    """Follows the autopilot's mode.

    Args:
        events: Where changes are reported.
        by_mode: Where a pilot who switches to the mode of external commands engages: why this is
            refused now, in words, or nothing; None where it never does.

    Attributes:
        state: Who flies.
    """

    def __init__(self, events: EventLog, by_mode: Callable[[], str] | None = None) -> None:
        self.state = State.IDLE
        self._events, self._by_mode = events, by_mode
        self._since = -math.inf
        self._heard = math.inf
        self._back = self._told_at = -math.inf  # when a silence has ended, and a mode was told
        self._ours_before: bool | None = None
        self._failsafe = False  # one may stand while we command: that of a low battery
        self._asked_in = ""  # name of the mode in which somebody engaged

    @property
    def commanding(self) -> bool:
        """Whether our commands fly."""
        return self.state is State.ENGAGED

    def ask(self, now: float, mode: str) -> None:
        """Somebody engages.

        Args:
            now: Our time in [s].
            mode: Name of the mode that the autopilot is in.
        """
        if self.state is not State.ENGAGED:
            self.state, self._since, self._asked_in = State.ASKING, now, mode

    def asked_long_enough(self, now: float) -> bool:
        """Whether asking ends here, for nothing: after :data:`PATIENCE`, whatever is heard.

        Args:
            now: Our time in [s].
        """
        if self.state is not State.ASKING or now - self._since <= PATIENCE:
            return False
        self.give_up(f"the autopilot stays in mode {self._asked_in}")
        return True

    def give_up(self, words: str, level: Level = Level.WARNING) -> None:
        """Command nothing any more.

        Args:
            words: Why.
            level: Of the event; what somebody has asked for is no warning.
        """
        if self.state is not State.IDLE:
            self.state = State.IDLE
            self._events.add(level, f"{words}; nothing is commanded until engaged again")

    def heard(self, now: float) -> None:
        """Take note that the autopilot was heard.

        Args:
            now: Our time in [s].
        """
        if now - self._heard > SILENCE:
            self._back = now
        self._heard = now

    def see_mode(self, now: float, ours: bool, name: str, armed: bool, failsafe: bool) -> None:
        """Take in the autopilot's mode.

        Args:
            now: Our time in [s].
            ours: Whether it is the mode of external commands.
            name: Of the mode.
            armed: Whether the motor may run.
            failsafe: Whether the autopilot says that it is in one.
        """
        before, self._ours_before = self._ours_before, ours
        fails, self._failsafe = failsafe and not self._failsafe, failsafe
        was_silent, self._told_at = self._told_at <= self._back, now
        if not armed:
            self.give_up("disarmed")
        elif ours:
            self._enter(switched=before is False)
        elif self.state is State.ASKING and name == self._asked_in:
            pass  # not yet
        elif self.state is State.ENGAGED and fails and was_silent:
            self.state = State.SUSPENDED
            self._events.add(
                Level.WARNING, f"the link was dead, the autopilot's failsafe flies in mode {name}"
            )
        elif self.state is not State.SUSPENDED or not failsafe:
            self.give_up(f"mode {name}: the pilot or the autopilot took over")

    def _enter(self, switched: bool) -> None:
        if self.state is State.ENGAGED:
            return
        if self.state is State.IDLE:
            if self._by_mode is None or not switched:
                return
            if refusal := self._by_mode():
                self._events.add(Level.WARNING, f"not engaged by the mode: {refusal}")
                return
        self.state = State.ENGAGED
        self._events.add(Level.INFO, "engaged: the aircraft flies our commands")
