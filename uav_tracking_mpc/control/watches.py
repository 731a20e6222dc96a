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

"""What goes wrong without failing: limit cycles, another orbit or airspeed than asked for.

A command in gusts or after noise swings as well as a loop at its limit of stability, but not with
one amplitude, nor at one period unless the loop has little damping.
"""

from __future__ import annotations

import contextlib
import math
from collections import deque
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from uav_tracking_mpc.control.event import EventLog, Level
from uav_tracking_mpc.dynamics.air import GRAVITY
from uav_tracking_mpc.dynamics.orbit import Orbit
from uav_tracking_mpc.dynamics.vehicle import followed
from uav_tracking_mpc.estimation.response_estimator import CHANNELS, ChannelResponse
from uav_tracking_mpc.formulation.formulation import Plan
from uav_tracking_mpc.parameters.specification import ParameterError, changed
from uav_tracking_mpc.settings.tracking import TrackingParameters

LEAST_AMPLITUDE = 0.05  # g across the path: 3 deg of bank
HALF_CYCLES = 11  # that must be alike, five periods and a half
GROWING = 6  # half cycles of a steady period that grow one by one are enough
SHORTEST, LONGEST = 0.08, 15.0  # s, of a period
# -, spread over mean, when it begins. Gusts and noise shake a loop with a damping ratio of 0.1 at
# one period as well, but with amplitudes that come and go: 0.5 in the long run.
PERIOD_SPREAD, AMPLITUDE_SPREAD = 0.12, 0.2
ENDING = 2.0  # -, factor on these spreads, and count of periods without a swing, when it ends
AVERAGING = 8.0  # s, time constant of the mean about which it swings
FORCED = 0.3  # -, share of a swing that the target's acceleration must have to be its cause
FORCED_TIME = 15.0  # s, in which the memory of the target's acceleration falls to 1/e
MARGIN = 2.5  # -, standard deviations of an airspeed that is not measured
UNKNOWN_SHARE, DOUBT_SHARE = 0.5, 0.7  # -, of the airspeed band, that a margin takes at most
MARGIN_STEP = 0.5  # m/s, by which it changes
CROSSING = 0.3  # -, of the least amplitude, by which a swing must pass the mean


class Swing(NamedTuple):
    """A sustained oscillation.

    Attributes:
        period: In [s].
        amplitude: From the mean in [g].
    """

    period: float
    amplitude: float


class LimitCycleWatch:
    """Watches one signal, an acceleration across the path in [g].

    Attributes:
        swing: The oscillation; None while there is none.
    """

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Forget what was seen."""
        self.swing: Swing | None = None
        self._time: float | None = None
        self._mean, self._peak, self._side, self._turned = 0.0, 0.0, 0, 0.0
        self._halves: deque[tuple[float, float]] = deque(maxlen=HALF_CYCLES)

    def see(self, time: float, value: float) -> bool:
        """Take in a sample.

        Args:
            time: In [s].
            value: In [g].

        Returns:
            Whether an oscillation has begun or ended.
        """
        if self._time is None or not 0.0 <= time - self._time <= LONGEST:
            self.reset()
            self._time, self._mean = time, value
            return False
        self._mean += followed(time - self._time, AVERAGING) * (value - self._mean)
        self._time = time
        off = value - self._mean
        before = self.swing
        if off * self._side <= 0.0 and abs(off) > CROSSING * LEAST_AMPLITUDE:
            self._halves.append((time - self._turned, self._peak))
            self._side, self._turned, self._peak = (1 if off > 0.0 else -1), time, 0.0
            self.swing = self._judged(1.0 if before is None else ENDING)
        elif before is not None and time - self._turned > ENDING * before.period:
            self.swing = None
        self._peak = max(self._peak, abs(off))
        return (before is None) is not (self.swing is None)

    @property
    def going_on(self) -> bool:
        """Whether it would be found again, and the latest swing from the mean was still as wide."""
        if self.swing is None or self._halves[-1][1] <= 0.5 * self.swing.amplitude:
            return False
        return self._judged(1.0) is not None

    def _judged(self, slack: float) -> Swing | None:
        """The oscillation that the last swings are, if they are one, with a factor on spreads."""
        if len(self._halves) < GROWING:
            return None
        halves, peaks = np.array(self._halves).T
        latest = halves[1 - GROWING :] + halves[-GROWING:-1]
        steady = np.std(latest) <= PERIOD_SPREAD * np.mean(latest)
        if slack == 1.0 and steady and np.all(np.diff(peaks[-GROWING:]) > 0.0):
            period, amplitude = float(np.mean(latest)), float(peaks[-1])
            if amplitude >= LEAST_AMPLITUDE and SHORTEST <= period <= LONGEST:
                return Swing(period, amplitude)
        if len(self._halves) < HALF_CYCLES:
            return None
        periods = halves[:-1] + halves[1:]
        period, amplitude = float(np.mean(periods)), float(np.mean(peaks))
        alike = (
            np.std(periods) <= slack * PERIOD_SPREAD * period
            and np.std(peaks) <= slack * AMPLITUDE_SPREAD * amplitude
        )
        strong = amplitude * slack >= LEAST_AMPLITUDE
        if alike and strong and SHORTEST <= period <= LONGEST:
            return Swing(period, amplitude)
        return None


NOTABLE_DELAY = 0.05  # s of lag and dead time between what is known and what is flown by


class OscillationReport:
    """Watches turn rate and path-angle rate as they are commanded.

    Args:
        events: Where to tell.

    Attributes:
        causes: What is likely to cause each oscillation, in words; empty where none is told.
    """

    def __init__(self, events: EventLog) -> None:
        self._events = events
        self._watches = LimitCycleWatch(), LimitCycleWatch()
        self.reset()

    @property
    def swings(self) -> tuple[Swing | None, Swing | None]:
        """Oscillations of turn rate and path-angle rate, amplitudes in [g].

        None where the target swings so much itself that the aircraft must.
        """
        turn, climb = [
            None if swing is None or self._forced > FORCED * swing.amplitude else swing
            for swing in [watch.swing for watch in self._watches]
        ]
        return turn, climb

    @property
    def going_on(self) -> tuple[bool, bool]:
        """Whether each of them goes on, rather than dies away."""
        turn, climb = self._watches
        return turn.going_on, climb.going_on

    def reset(self) -> None:
        """Forget what was seen."""
        for watch in self._watches:
            watch.reset()
        self.causes = ["", ""]
        self._forced, self._time = 0.0, -math.inf

    def see(
        self,
        time: float,
        inputs: Sequence[float],
        airspeed: float,
        channels: Sequence[ChannelResponse],
        delays: Sequence[float],
        forced: float = 0.0,
    ) -> None:
        """Take in a command.

        Args:
            time: In [s].
            inputs: (u_psi, u_chi), or the first where that alone is commanded, in [rad/s].
            airspeed: v in [m/s].
            channels: What is known of the response of each channel.
            delays: Lag plus dead time that each channel is flown by, in [s].
            forced: Horizontal acceleration of the target in [m/s^2].
        """
        kept = math.exp(-max(0.0, time - self._time) / FORCED_TIME)
        self._forced, self._time = max(kept * self._forced, forced / GRAVITY), time
        for watch, rate in zip(self._watches, inputs, strict=False):
            watch.see(time, airspeed * rate / GRAVITY)
        for axis, (watch, swing) in enumerate(zip(self._watches, self.swings, strict=True)):
            cycle = f"limit cycle of the {CHANNELS[axis]}"
            if swing is not None and not self.causes[axis]:
                self.causes[axis] = _cause(channels[axis], delays[axis])
                self._events.add(Level.WARNING, f"{cycle}: {self.words(axis)}")
            elif watch.swing is None and self.causes[axis]:
                self.causes[axis] = ""
                self._events.add(Level.INFO, f"the {cycle} has ended")

    def words(self, axis: int) -> str:
        """The oscillation of a channel; "none" without one.

        Args:
            axis: 0 for turn rate, 1 for path-angle rate.
        """
        if (swing := self.swings[axis]) is None:
            return "none"
        bank = f"{math.degrees(math.atan(swing.amplitude)):.0f} deg of bank"
        size = f"{swing.amplitude:.2f} g" if axis else bank
        return f"+-{size} with a period of {swing.period:.1f} s; likely {self.causes[axis]}"


def _cause(channel: ChannelResponse, delay: float) -> str:
    """What is likely behind an oscillation."""
    if channel.trusted and abs(channel.delay - delay) > NOTABLE_DELAY:
        return (
            f"because lag and dead time are together {channel.delay:.2f} s, not {delay:.2f} s as "
            "they are flown by"
        )
    if not channel.trusted:
        return "because lag, dead time or the age of the state is not what was told"
    return "because the weights of the inputs are too small, or the aircraft's limits not told"


# m, m, m/s: differences in range, altitude and airspeed that are worth a word, and by how much an
# orbit that stays may still change.
NOTABLE_ORBIT = 1.0, 2.0, 0.5
LASTING = 10.0  # s for which it must have been different, and the same


class AirspeedMargin:
    """Keeps an orbit away from both airspeed limits while the airspeed is not known for sure.

    If the airspeed is not measured, the margin is :data:`MARGIN` standard deviations of what wind
    and ground velocity tell, at most half of the band; plans keep half of the margin. If it is
    measured and they contradict it, the margin is what they contradict it by.

    Args:
        asked: What the user wants.
        events: Where to tell.
    """

    def __init__(self, asked: TrackingParameters, events: EventLog) -> None:
        self._events, self._told = events, False
        self.forget(asked)

    def forget(self, asked: TrackingParameters) -> None:
        """Begin without a margin: other parameters are flown by.

        Args:
            asked: Those.
        """
        self._asked, self._margins = asked, [0.0, 0.0]

    def flown(
        self, asked: TrackingParameters, deviation: float, doubts: tuple[float, float] = (0.0, 0.0)
    ) -> TrackingParameters | None:
        """What is to be flown by from now on.

        Args:
            asked: What the user wants, as far as the aircraft gives it.
            deviation: Standard deviation of the airspeed in [m/s]; 0 while it is measured.
            doubts: By how much a measured one may be too high, and too low, in [m/s].

        Returns:
            None where that has not changed.
        """
        band = asked.airspeed_max - asked.airspeed_min
        unknown = min(MARGIN * deviation, UNKNOWN_SHARE * band)
        spaces = asked.airspeed - asked.airspeed_min, asked.airspeed_max - asked.airspeed
        margins = []
        for doubt, space, before in zip(doubts, spaces, self._margins, strict=True):
            safe = min(MARGIN * doubt, DOUBT_SHARE * band)
            wanted = safe if safe > max(unknown, space) else unknown
            wanted = wanted if wanted >= MARGIN_STEP else 0.0
            same = abs(wanted - before) < MARGIN_STEP and (wanted > 0.0) == (before > 0.0)
            margins.append(before if same else wanted)
        unsure = any(margins)
        if asked is self._asked and (margins, unsure) == (self._margins, self._told):
            return None
        self._asked, self._margins = asked, margins
        flown = kept_away(asked, *margins) if unsure else asked
        if self._told != unsure:
            self._told = unsure
            state = "in doubt" if any(doubts) else "not known"
            words = f"the airspeed is {state}: the orbit is flown at {flown.airspeed:.1f} m/s"
            self._events.add(Level.INFO, words if unsure else "the airspeed is known again")
        return flown


def kept_away(asked: TrackingParameters, above: float, below: float) -> TrackingParameters:
    """Parameters with an orbit away from the limits of the airspeed, as far as the bank allows it.

    Args:
        asked: What the user wants.
        above: The least airspeed, in [m/s].
        below: The greatest one, in [m/s].
    """
    least, most = asked.airspeed_min, asked.airspeed_max
    for share in (1.0, 0.75, 0.5, 0.25):
        orbit = min(max(asked.airspeed, least + share * above), most - share * below)
        band = {
            "airspeed_min": least + 0.5 * share * above,
            "airspeed_max": most - 0.5 * share * below,
        }
        with contextlib.suppress(ParameterError):
            return changed(asked, {**band, "airspeed": orbit})
    return asked


AIRSPEED_SLACK, AIRSPEED_TIME = 0.5, 5.0  # m/s beyond a limit, for s, that are worth a word


class AirspeedWatch:
    """Tells an airspeed that stays beyond its limits, as after an engine that has failed.

    Args:
        events: Where to tell.
    """

    def __init__(self, events: EventLog) -> None:
        self._events = events
        self.reset()

    def reset(self) -> None:
        """Forget what was flown."""
        self._told, self._begin = False, math.inf

    def see(self, time: float, airspeed: float, asked: TrackingParameters) -> None:
        """Take in an airspeed.

        Args:
            time: Now in [s].
            airspeed: As it is known in [m/s].
            asked: With its limits.
        """
        least, most = asked.airspeed_min, asked.airspeed_max
        beyond = max(least - airspeed, airspeed - most)
        if not beyond > (0.0 if self._told else AIRSPEED_SLACK):
            if self._told:
                self._events.add(Level.INFO, "the airspeed is inside its limits again")
            self.reset()
            return
        self._begin = min(self._begin, time)
        if not self._told and time - self._begin >= AIRSPEED_TIME:
            self._told = True
            low = f"below airspeed_min {least:g} m/s", ": does the engine run?"
            high = f"above airspeed_max {most:g} m/s", ""
            limit, question = low if airspeed < least else high
            words = f"the airspeed is {airspeed:.1f} m/s, {limit} for {AIRSPEED_TIME:g} s{question}"
            self._events.add(Level.WARNING, words)


class OrbitShortfall:
    """Compares the artificial orbit of each plan with what is wanted.

    A flight on its way to the orbit passes through others: only one that stays is told.

    Args:
        events: Where to tell.
    """

    def __init__(self, events: EventLog) -> None:
        self._events = events
        self.reset()

    def reset(self) -> None:
        """Forget what was flown."""
        self._told, self._candidate, self._begin = False, [math.inf] * 3, 0.0

    def see(self, time: float, plan: Plan, wanted: Orbit) -> None:
        """Take in a plan.

        Args:
            time: Now in [s].
            plan: That is flown.
            wanted: What was asked for.
        """
        if plan.orbit is None:
            return
        asked, flown = [wanted.range, wanted.altitude, wanted.speed], plan.orbit.tolist()
        if _alike(flown, asked):
            if self._told:
                self._events.add(Level.INFO, "the orbit that was asked for is flown again")
            self.reset()
        elif not _alike(flown, self._candidate):
            self._candidate, self._begin = flown, time
        elif not self._told and time - self._begin >= LASTING:
            self._told = True
            self._events.add(
                Level.WARNING,
                f"limits and drift leave no orbit of {_words(asked)}: flying {_words(flown)}",
            )


def _alike(one: list[float], other: list[float]) -> bool:
    """Whether the difference of two orbits is worth no word."""
    return all(abs(a - b) < least for a, b, least in zip(one, other, NOTABLE_ORBIT, strict=True))


def _words(orbit: list[float]) -> str:
    distance, altitude, speed = orbit
    return f"{distance:.1f} m at {altitude:.1f} m and {speed:.1f} m/s"
