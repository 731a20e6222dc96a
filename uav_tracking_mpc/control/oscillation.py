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

"""Tells limit cycles of bank and path, in words, with what is likely to cause them."""

from __future__ import annotations

import math
from collections.abc import Sequence

from uav_tracking_mpc.control.event import EventLog, Level
from uav_tracking_mpc.control.limit_cycle import LimitCycleWatch, Swing
from uav_tracking_mpc.dynamics.gravity import GRAVITY
from uav_tracking_mpc.estimation.channel_response import CHANNELS, ChannelResponse

NOTABLE = 0.05  # s of lag and dead time between what is known and what is flown by


class OscillationReport:
    """Watches turn rate and path-angle rate as they are commanded.

    Args:
        events: Where to tell.

    Attributes:
        causes: What is likely to cause each oscillation, in words.
    """

    def __init__(self, events: EventLog) -> None:
        self._events = events
        self._watches = LimitCycleWatch(), LimitCycleWatch()
        self.causes = ["", ""]

    @property
    def swings(self) -> tuple[Swing | None, Swing | None]:
        """Oscillations of turn rate and path-angle rate, amplitudes in [g]."""
        turn, climb = self._watches
        return turn.swing, climb.swing

    def reset(self) -> None:
        """Forget what was seen."""
        for watch in self._watches:
            watch.reset()
        self.causes = ["", ""]

    def see(
        self,
        time: float,
        inputs: Sequence[float],
        airspeed: float,
        channels: Sequence[ChannelResponse],
        delays: Sequence[float],
    ) -> None:
        """Take in a command.

        Args:
            time: In [s].
            inputs: (u_psi, u_chi), or the first where that alone is commanded, in [rad/s].
            airspeed: v in [m/s].
            channels: What is known of the response of each channel.
            delays: Lag plus dead time that each channel is flown by, in [s].
        """
        for axis, (watch, rate) in enumerate(zip(self._watches, inputs, strict=False)):
            if not watch.see(time, airspeed * rate / GRAVITY):
                continue
            if watch.swing is None:
                self._events.add(Level.INFO, f"the limit cycle of the {CHANNELS[axis]} has ended")
                continue
            self.causes[axis] = _cause(channels[axis], delays[axis])
            words = f"limit cycle of the {CHANNELS[axis]}: {described(axis, watch.swing)}"
            self._events.add(Level.WARNING, f"{words}; likely {self.causes[axis]}")

    def words(self, axis: int) -> str:
        """The oscillation of a channel; "none" without one.

        Args:
            axis: 0 for turn rate, 1 for path-angle rate.
        """
        swing = self.swings[axis]
        return "none" if swing is None else f"{described(axis, swing)}; likely {self.causes[axis]}"


def described(axis: int, swing: Swing) -> str:
    """An oscillation in words.

    Args:
        axis: 0 for turn rate, 1 for path-angle rate.
        swing: What it is, amplitude in [g].
    """
    if axis == 0:
        size = f"{math.degrees(math.atan(swing.amplitude)):.0f} deg of bank"
    else:
        size = f"{swing.amplitude:.2f} g"
    return f"+-{size} with a period of {swing.period:.1f} s"


def _cause(channel: ChannelResponse, delay: float) -> str:
    """What is likely behind an oscillation."""
    if channel.trusted and abs(channel.delay - delay) > NOTABLE:
        return (
            f"because lag and dead time are together {channel.delay:.2f} s, not {delay:.2f} s as "
            "they are flown by"
        )
    if not channel.trusted:
        return "because lag, dead time or the age of the state is not what was told"
    return "because the weights of the inputs are too small, or the aircraft's limits not told"
