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

"""What a flight says of one channel: what was demanded, and what was measured of the answer."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

TURN, PATH, SPEED = "turn", "path", "speed"
CHANNELS = (TURN, PATH, SPEED)  # in the order of (u_psi, u_chi, u_v)
UNITS = {TURN: "rad/s", PATH: "rad/s", SPEED: "m/s^2"}  # of what is demanded
WARM_UP = 5.0  # s after the first command, of which what came before it has no more part
SHORTEST = 10.0  # s of measurements, below which nothing can be said


class Samples(NamedTuple):
    """Values over time.

    Attributes:
        time: In [s], shape (n,), increasing.
        value: In the quantity's own unit, shape (n,).
    """

    time: NDArray[np.float64]
    value: NDArray[np.float64]


@dataclass(frozen=True)
class ChannelRecord:
    """One channel over a flight.

    Attributes:
        name: One of :data:`CHANNELS`.
        demand: Rates demanded, each held until the next one.
        state: What the rate integrates to: heading (unwrapped), path angle or airspeed.
        rate: The rate itself, where it is measured.
        leverage: By what the demand is multiplied before it meets its limit, at each demand,
            shape (m,), in [s] or [-]: v / g in a turn, which banks by tan(bank) = v u_psi / g.
    """

    name: str
    demand: Samples
    state: Samples
    rate: Samples | None
    leverage: NDArray[np.float64]

    @classmethod
    def of(
        cls,
        name: str,
        demand: Samples,
        state: Samples,
        rate: Samples | None,
        leverage: NDArray[np.float64],
    ) -> ChannelRecord:
        """A record without what was measured before or long after commands.

        Args:
            name: One of :data:`CHANNELS`.
            demand: As above.
            state: As above.
            rate: As above.
            leverage: As above, shape (m,), in [s] or [-].

        Raises:
            ValueError: There are too few measurements between commands.
        """
        begin, end = demand.time[0] + WARM_UP, demand.time[-1] + 1.0

        def within(samples: Samples) -> Samples:
            inside = (samples.time >= begin) & (samples.time <= end)
            return Samples(samples.time[inside], samples.value[inside])

        kept = within(state)
        length = kept.time[-1] - kept.time[0] if len(kept.time) else 0.0
        if not length >= SHORTEST:
            raise ValueError(
                f"channel {name}: {length:.1f} s of measurements with commands, must be at least "
                f"{SHORTEST:g} s beginning {WARM_UP:g} s after the first command"
            )
        return cls(name, demand, kept, None if rate is None else within(rate), leverage)
