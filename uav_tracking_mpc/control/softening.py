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

r"""A loop that swings is made slower until it stops, whatever the cause; then it comes back.

The weights W of the inputs' rates are multiplied by a factor. With weights on the range error e and
on the turn acceleration alone, where :math:`e^{(3)} = v \omega'`, the bandwidth of the loop goes as
:math:`(q v^2 / W)^{1/6}`: a factor of 64 halves it, and doubles the delay that the loop bears. A
limit cycle multiplies W at once, and again for as long as it goes on. When it has been quiet for a
while W comes back, slowly, and no further than to where the loop swung last; where the response
that is flown by has changed since, all the way.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from uav_tracking_mpc.control.event import EventLog, Level
from uav_tracking_mpc.control.watches import Swing
from uav_tracking_mpc.estimation.response_estimator import CHANNELS

STEP, MOST = 8.0, 8.0**5  # -, factor of each step, and of all of them
LASTING = 1.5  # -, periods for which a swing must go on to be answered again
LEAST_TIME = 0.3  # s, of a plan with other weights before they are judged
QUIET = 15.0  # s without a swing before the gain comes back
RETURN_TIME = 10.0  # s, in which the factor falls to 1/e of itself
CLEAR = 2.0  # -: the weight stays at least so many times as great as when the loop swung last
OTHER_DELAY, OTHER_GAIN = 0.05, 0.05  # s, -: changes of the response that make it another loop
ROUNDING = 1e-3  # -, of the factor


class _Channel:
    """Factor of one channel's weight, and where it has swung."""

    def __init__(self) -> None:
        self.factor = self.floor = 1.0
        self.quiet_since = self.judged = -math.inf
        self.response = (math.inf, math.inf)  # delay [s] and gain [-] when it swung last


class Softening:
    """Factors of the weights of the inputs' rates.

    Args:
        events: Where it is told.

    Attributes:
        factors: Of turn rate, path-angle rate and acceleration, shape (3,), 1 or more [-].
    """

    def __init__(self, events: EventLog) -> None:
        self._events = events
        self.reset()

    def reset(self) -> None:
        """Back to the weights as they are told."""
        self._channels = [_Channel(), _Channel()]
        self._time: float | None = None
        self.factors = np.ones(3)

    def follow(
        self,
        time: float,
        swings: tuple[Swing | None, Swing | None],
        going_on: tuple[bool, bool],
        delays: Sequence[float],
        gains: Sequence[float],
    ) -> bool:
        """Answer the swings of now.

        Args:
            time: Now in [s].
            swings: Of turn rate and path-angle rate; None where there is none, or where the target
                swings as much: the gain then stays as it is.
            going_on: Whether the aircraft's swing goes on, rather than dies away.
            delays: Lag plus dead time of each channel as they are flown by, shape (3,), in [s].
            gains: Of each channel, likewise, shape (3,), [-].

        Returns:
            Whether the factors have changed.
        """
        elapsed = 0.0 if self._time is None else max(0.0, time - self._time)
        self._time = time
        changed = False
        for axis, (channel, swing) in enumerate(zip(self._channels, swings, strict=True)):
            flown = delays[axis], gains[axis]
            # Where time has gone back, nothing is awaited from a time that is no more.
            channel.quiet_since = min(channel.quiet_since, time)
            channel.judged = min(channel.judged, time)
            if swing is not None or going_on[axis]:
                channel.quiet_since = time
                if swing is not None and going_on[axis]:
                    self._soften(axis, channel, time, swing, flown)
            elif channel.factor > 1.0 and time - channel.quiet_since >= QUIET:
                self._return(axis, channel, elapsed, flown)
            if channel.factor != self.factors[axis]:
                self.factors[axis], changed = channel.factor, True
        return changed

    def _soften(
        self, axis: int, channel: _Channel, time: float, swing: Swing, flown: tuple[float, float]
    ) -> None:
        if time - channel.judged < max(LASTING * swing.period, LEAST_TIME):
            return
        channel.judged, channel.response = time, flown
        channel.floor = min(CLEAR * channel.factor, MOST)
        if channel.factor < MOST:
            channel.factor = min(STEP * channel.factor, MOST)
            words = f"the loop is softened: changes of the {CHANNELS[axis]} weigh "
            self._events.add(Level.WARNING, f"{words}{channel.factor:.0f} times as much")

    def _return(
        self, axis: int, channel: _Channel, elapsed: float, flown: tuple[float, float]
    ) -> None:
        delay, gain = channel.response
        if abs(flown[0] - delay) > OTHER_DELAY or abs(flown[1] - gain) > OTHER_GAIN:
            channel.floor = 1.0
        back = channel.factor * math.exp(-elapsed / RETURN_TIME)
        if back > max(channel.floor, 1.0 + ROUNDING):
            channel.factor = back
        elif channel.factor > channel.floor:
            channel.factor = channel.floor
            if channel.floor == 1.0:
                words = f"changes of the {CHANNELS[axis]} weigh as they are told again"
                self._events.add(Level.INFO, words)
