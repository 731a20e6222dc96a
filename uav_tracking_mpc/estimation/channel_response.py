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

"""How a channel of the aircraft answers commands, as far as it has shown in flight."""

from __future__ import annotations

import math
from typing import NamedTuple

CHANNELS = ("turn rate", "path-angle rate", "acceleration")
# The sum of lag and dead time, or the lag alone, is trusted below the first deviation and until the
# second: what it is off by adds to the phase. The gain likewise.
DELAY_TRUST = (0.05, 0.1)  # s
GAIN_TRUST = (0.03, 0.06)  # -
# Deviation of the gain beyond which there may be no response at all, only noise that looks alike.
RESPONSE_TRUST = 0.1


class ChannelResponse(NamedTuple):
    """A first-order lag behind a dead time, with standard deviations.

    The sum of lag and dead time shows far better than each of them: what one is too long, the other
    is too short.

    Attributes:
        lag: Time constant in [s].
        dead_time: In [s].
        gain: Rate that is flown per rate that is commanded [-].
        lag_deviation: Standard deviation of the lag in [s].
        dead_time_deviation: Of the dead time in [s].
        delay_deviation: Of their sum in [s].
        gain_deviation: Of the gain [-].
        trusted: Whether the sum is known well enough to fly by.
        lag_trusted: Whether the lag alone is.
        gain_trusted: Whether the gain is.
    """

    lag: float = 0.0
    dead_time: float = 0.0
    gain: float = 1.0
    lag_deviation: float = math.inf
    dead_time_deviation: float = math.inf
    delay_deviation: float = math.inf
    gain_deviation: float = math.inf
    trusted: bool = False
    lag_trusted: bool = False
    gain_trusted: bool = False

    @property
    def delay(self) -> float:
        """Lag plus dead time in [s]."""
        return self.lag + self.dead_time

    def judged(self, before: ChannelResponse) -> ChannelResponse:
        """This estimate with what may be trusted of it, with hysteresis.

        Args:
            before: The estimate before this one.
        """
        seen = self.gain_deviation < RESPONSE_TRUST
        return self._replace(
            trusted=seen and self.delay_deviation < DELAY_TRUST[before.trusted],
            lag_trusted=seen and self.lag_deviation < DELAY_TRUST[before.lag_trusted],
            gain_trusted=self.gain_deviation < GAIN_TRUST[before.gain_trusted],
        )
