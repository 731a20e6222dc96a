"""The autopilot's inner loop: each rate follows its command after a dead time, with a lag."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence

TIME_ROUNDING = 1e-7  # s; what is due within it is due


class Channel:
    """One rate: lag * rate' = wanted - rate, where wanted(t) = command(t - dead_time).

    Args:
        lag: Time constant in [s]; 0 follows at once.
        dead_time: In [s].

    Attributes:
        rate: Flown now.
        wanted: The command that it follows now.
    """

    def __init__(self, lag: float, dead_time: float) -> None:
        self.lag, self.dead_time = lag, dead_time
        self.rate = self.wanted = 0.0
        self._pending: deque[tuple[float, float]] = deque()  # when it becomes wanted, and what

    def command(self, time: float, value: float) -> None:
        """Take in what is commanded from ``time`` on; later commands are of a time undone."""
        due = time + self.dead_time
        self.mature(time)
        while self._pending and self._pending[-1][0] >= due - TIME_ROUNDING:
            self._pending.pop()
        if self.dead_time == 0.0:
            self.wanted = value
        elif value != (self._pending[-1][1] if self._pending else self.wanted):
            self._pending.append((due, value))

    def mature(self, time: float) -> None:
        """Follow the command that the dead time has let through by ``time``."""
        while self._pending and self._pending[0][0] <= time + TIME_ROUNDING:
            self.wanted = self._pending.popleft()[1]

    @property
    def next_change(self) -> float:
        """When it will follow another command, as far as is known, in [s]."""
        return self._pending[0][0] if self._pending else math.inf

    def after(self, duration: float) -> tuple[float, float]:
        """Rate at the end of a time in which ``wanted`` stays, and its integral; exact."""
        if self.lag == 0.0:
            return self.wanted, self.wanted * duration
        excess = self.rate - self.wanted
        gone = -math.expm1(-duration / self.lag)
        return self.rate - excess * gone, self.wanted * duration + excess * self.lag * gone


class InnerLoop:
    """The channels of turn rate, path-angle rate and acceleration.

    Args:
        lags: Time constants in [s], three.
        dead_times: In [s], three.

    Attributes:
        channels: The three.
    """

    def __init__(self, lags: Sequence[float], dead_times: Sequence[float]) -> None:
        turn, climb, acceleration = zip(lags, dead_times, strict=True)
        self.channels = Channel(*turn), Channel(*climb), Channel(*acceleration)

    def command(self, time: float, inputs: Sequence[float]) -> None:
        """Take in the inputs (u_psi, u_chi, u_v) commanded from ``time`` [s] on."""
        for channel, value in zip(self.channels, inputs, strict=True):
            channel.command(time, value)

    def unchanged_until(self, time: float) -> float:
        """Follow what is due at ``time`` [s]; when the next command is."""
        for channel in self.channels:
            channel.mature(time)
        return min(channel.next_change for channel in self.channels)
