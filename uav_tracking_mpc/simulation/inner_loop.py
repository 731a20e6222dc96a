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

r"""The autopilot's inner loop: each rate follows its command after a dead time, with a lag.

The turn rate may follow as a damped oscillation instead, as the roll of many aircraft does.

While rates still approach their commands, heading, path angle and airspeed are sums of
exponentials in closed form; only the position, the integral of
:func:`~uav_tracking_mpc.dynamics.vehicle.air_velocity`, is left to a quadrature, Gauss-Legendre
with five points on panels that are short beside any turn.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence

import numpy as np

from uav_tracking_mpc.dynamics.frames import wrap_angle
from uav_tracking_mpc.dynamics.vehicle import air_velocity, followed

TIME_ROUNDING = 1e-7  # s, rounding by which a command may take effect too early


class Channel:
    """One rate: lag * rate' = wanted - rate, where wanted(t) = command(t - dead_time).

    Args:
        lag: Time constant in [s]; 0 follows at once.
        dead_time: In [s].

    Attributes:
        lag: As above.
        dead_time: As above.
        rate: Flown now, in [rad/s] or [m/s^2].
        wanted: The command that it follows now, in the same unit.
    """

    def __init__(self, lag: float, dead_time: float) -> None:
        self.lag, self.dead_time = lag, dead_time
        self.rate = self.wanted = 0.0
        self._pending: deque[tuple[float, float]] = deque()  # when it becomes wanted, and what

    def command(self, time: float, value: float) -> None:
        """Record a command that takes effect a dead time later.

        Commands recorded for later times are discarded: the clock went back.

        Args:
            time: From which it is commanded in [s].
            value: Rate that is commanded, in its own unit, [rad/s] or [m/s^2].
        """
        due = time + self.dead_time
        self.mature(time)
        while self._pending and self._pending[-1][0] >= due - TIME_ROUNDING:
            self._pending.pop()
        if self.dead_time == 0.0:
            self.wanted = value
        elif value != (self._pending[-1][1] if self._pending else self.wanted):
            self._pending.append((due, value))

    def mature(self, time: float) -> None:
        """Follow the newest command whose dead time is over.

        Args:
            time: Now in [s].
        """
        while self._pending and self._pending[0][0] <= time + TIME_ROUNDING:
            self.wanted = self._pending.popleft()[1]

    @property
    def next_change(self) -> float:
        """When the next recorded command takes effect in [s]; infinite without one."""
        return self._pending[0][0] if self._pending else math.inf

    def rate_after(self, duration: float) -> float:
        """Rate at the end of a time in which ``wanted`` stays, in its own unit; exact.

        Args:
            duration: Of that time in [s].
        """
        if self.lag == 0.0:
            return self.wanted
        return self.rate + (self.wanted - self.rate) * followed(duration, self.lag)

    def integral(self, duration: float) -> float:
        """Integral of the rate over a time in which ``wanted`` stays, in [rad] or [m/s]; exact.

        Args:
            duration: Of that time in [s].
        """
        begun = (self.rate - self.wanted) * self.lag * followed(duration, self.lag)
        return self.wanted * duration + begun

    def follow(self, duration: float) -> None:
        """Move the rate on by a time in which ``wanted`` stays.

        Args:
            duration: Of that time in [s].
        """
        self.rate = self.rate_after(duration)


class OscillatingChannel(Channel):
    """One rate: rate'' + 2 d w rate' + w^2 rate = w^2 wanted, w the frequency, d the damping.

    Args:
        frequency: Natural frequency w in [rad/s].
        damping: Damping ratio d, below 1, [-].
        dead_time: In [s].
    """

    def __init__(self, frequency: float, damping: float, dead_time: float) -> None:
        super().__init__(2.0 * damping / frequency, dead_time)  # the lag that it is alike
        self._frequency, self._decay = frequency, damping * frequency
        self._swing = frequency * math.sqrt(1.0 - damping**2)
        self._slope = 0.0  # rate'

    def _after(self, duration: float) -> tuple[float, float]:
        """What the rate is off what is wanted after a time, and its slope."""
        off, decay, swing = self.rate - self.wanted, self._decay, self._swing
        across = (self._slope + decay * off) / swing
        cos, sin = math.cos(swing * duration), math.sin(swing * duration)
        left = math.exp(-decay * duration)
        after = left * (off * cos + across * sin)
        return after, left * swing * (across * cos - off * sin) - decay * after

    def rate_after(self, duration: float) -> float:
        """See :meth:`Channel.rate_after`."""
        return self.wanted + self._after(duration)[0]

    def integral(self, duration: float) -> float:
        """See :meth:`Channel.integral`."""
        after, slope = self._after(duration)
        lost = slope - self._slope + 2.0 * self._decay * (after - self.rate + self.wanted)
        return self.wanted * duration - lost / self._frequency**2

    def follow(self, duration: float) -> None:
        """See :meth:`Channel.follow`."""
        after, self._slope = self._after(duration)
        self.rate = self.wanted + after


class InnerLoop:
    """The channels of turn rate, path-angle rate and acceleration.

    Args:
        lags: Time constants in [s], three.
        dead_times: In [s], three.
        turn: Of the turn rate, where it does not follow with its lag.

    Attributes:
        channels: The three.
    """

    def __init__(
        self, lags: Sequence[float], dead_times: Sequence[float], turn: Channel | None = None
    ) -> None:
        lagging, climb, gain = (Channel(*each) for each in zip(lags, dead_times, strict=True))
        self.channels = turn or lagging, climb, gain

    def command(self, time: float, inputs: Sequence[float]) -> None:
        """Record inputs that take effect a dead time later.

        Args:
            time: From which they are commanded in [s].
            inputs: (u_psi, u_chi, u_v), shape (3,), in [rad/s], [rad/s] and [m/s^2].
        """
        for channel, value in zip(self.channels, inputs, strict=True):
            channel.command(time, value)

    def unchanged_until(self, time: float) -> float:
        """Follow the commands whose dead time is over.

        Args:
            time: Now in [s].

        Returns:
            When the next command takes effect in [s]; infinite without one.
        """
        for channel in self.channels:
            channel.mature(time)
        return min(channel.next_change for channel in self.channels)


PANEL = 0.05  # s, longest
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(5)
POINTS = tuple(zip((0.5 * (1.0 + _NODES)).tolist(), (0.5 * _WEIGHTS).tolist(), strict=True))


def advance_lagged(
    state: Sequence[float], channels: tuple[Channel, Channel, Channel], duration: float
) -> tuple[float, float, float, float, float, float]:
    """State after ``duration``, with what each channel wants held.

    Args:
        state: (x, y, z, psi, chi, v), shape (6,), in [m], [rad] and [m/s].
        channels: Of turn rate, path-angle rate and acceleration; their rates are moved on.
        duration: In [s], positive.

    Returns:
        State at the end, shape (6,), angles wrapped to (-pi, pi].
    """
    x, y, z, psi, chi, v = state
    turn, climb, engine = channels
    count = math.ceil(duration / PANEL)
    step = duration / count
    for _ in range(count):
        for point, weight in POINTS:
            moment = point * step
            heading = psi + turn.integral(moment)
            path_angle = chi + climb.integral(moment)
            airspeed = v + engine.integral(moment)
            east, north, up = air_velocity(heading, path_angle, airspeed, math)
            x += weight * step * east
            y += weight * step * north
            z += weight * step * up
        psi, chi, v = (
            start + channel.integral(step)
            for start, channel in zip((psi, chi, v), channels, strict=True)
        )
        for channel in channels:
            channel.follow(step)
    if max(abs(psi), abs(chi)) >= math.pi:  # seldom, and slow
        psi, chi = wrap_angle([psi, chi]).tolist()
    return x, y, z, psi, chi, v
