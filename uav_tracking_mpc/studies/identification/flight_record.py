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

"""A flight as its file tells: plans as they were flown, and what was measured of each channel."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from uav_tracking_mpc.dynamics.air import GRAVITY

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


LAST_SEGMENT = 1.0  # s, of a plan that has one segment only


class RecordError(ValueError):
    """A file does not hold what is needed; the message says what is missing."""


class FlownPlan(NamedTuple):
    """A plan as it came.

    Attributes:
        time: From which on it was flown, in [s]: when the aircraft got it.
        starts: When its segments begin, shape (n,), in [s].
        inputs: (u_psi, u_chi, u_v) of each, shape (n, 3), in [rad/s, rad/s, m/s^2].
    """

    time: float
    starts: NDArray[np.float64]
    inputs: NDArray[np.float64]

    @property
    def end(self) -> float:
        """When nothing is left of it, in [s]."""
        last = self.starts[-1] - self.starts[-2] if len(self.starts) > 1 else LAST_SEGMENT
        return float(self.starts[-1] + last)


class Demand(NamedTuple):
    """What was demanded of all channels, held from each time to the next.

    Attributes:
        time: Shape (m,), in [s], increasing.
        inputs: (u_psi, u_chi, u_v), shape (m, 3), in [rad/s, rad/s, m/s^2].
    """

    time: NDArray[np.float64]
    inputs: NDArray[np.float64]


def flown_demand(plans: Sequence[FlownPlan]) -> Demand:
    """What plans demanded over the longest time in which there was always one to fly.

    Args:
        plans: In the order in which they came.

    Raises:
        RecordError: There is none.
    """
    if not plans:
        raise RecordError("there are no commands")
    stretches: list[list[FlownPlan]] = [[]]
    for plan in plans:
        if stretches[-1] and plan.time > stretches[-1][-1].end:
            stretches.append([])
        stretches[-1].append(plan)
    longest = max(stretches, key=lambda stretch: stretch[-1].time - stretch[0].time)
    times, inputs = [], []
    for plan, until in zip(longest, [*(p.time for p in longest[1:]), longest[-1].end], strict=True):
        first = max(int(np.searchsorted(plan.starts, plan.time, side="right")) - 1, 0)
        begins = np.maximum(plan.starts[first:], plan.time)
        flown = begins < until
        times.append(begins[flown])
        inputs.append(plan.inputs[first:][flown])
    return Demand(np.concatenate(times), np.concatenate(inputs))


@dataclass(frozen=True)
class FlightRecord:
    """A flight, as far as its file tells.

    Attributes:
        demand: What was commanded.
        heading: psi, wrapped or not.
        path_angle: chi.
        airspeed: v; None where it was not measured.
        turn_rate: psi'; None where it was not measured.
        path_angle_rate: chi'; None where it was not measured.
    """

    demand: Demand
    heading: Samples
    path_angle: Samples
    airspeed: Samples | None
    turn_rate: Samples | None
    path_angle_rate: Samples | None

    def channels(self) -> list[ChannelRecord]:
        """Each channel that was measured.

        Raises:
            RecordError: There are too few measurements.
        """
        time = self.demand.time
        turn, path, speed = (Samples(time, inputs) for inputs in self.demand.inputs.T)
        ones = np.ones_like(time)
        lateral = ones
        if self.airspeed is not None and len(self.airspeed.time):
            lateral = _smooth(time, self.airspeed) / GRAVITY
        heading = self.heading._replace(value=np.unwrap(self.heading.value))
        found = [
            (TURN, turn, heading, self.turn_rate, lateral),
            (PATH, path, self.path_angle, self.path_angle_rate, ones),
        ]
        if self.airspeed is not None:
            found.append((SPEED, speed, self.airspeed, None, ones))
        try:
            return [
                ChannelRecord.of(name, demand, state, _moving(rate), leverage)
                for name, demand, state, rate, leverage in found
            ]
        except ValueError as error:
            raise RecordError(str(error)) from error


def samples(time: ArrayLike, values: ArrayLike) -> Samples:
    """Samples in order, one at a time, without what is no number.

    Args:
        time: In [s], in any order, shape (n,).
        values: Shape (n,).
    """
    times, held = np.asarray(time, dtype=float), np.asarray(values, dtype=float)
    known = np.isfinite(times) & np.isfinite(held)
    unique, first = np.unique(times[known], return_index=True)
    return Samples(unique, held[known][first])


def _moving(rate: Samples | None) -> Samples | None:
    """None for a rate that never changes: its sender does not measure it."""
    return None if rate is None or not len(rate.value) or np.ptp(rate.value) == 0.0 else rate


def _smooth(time: NDArray[np.float64], noisy: Samples) -> NDArray[np.float64]:
    """Means over a second, at other times, shape (n,)."""
    sums = np.concatenate([[0.0], np.cumsum(noisy.value)])
    first = np.searchsorted(noisy.time, time - 0.5)
    last = np.maximum(np.searchsorted(noisy.time, time + 0.5), first + 1)
    first, last = np.minimum(first, len(noisy.value) - 1), np.minimum(last, len(noisy.value))
    return (sums[last] - sums[first]) / np.maximum(last - first, 1)
