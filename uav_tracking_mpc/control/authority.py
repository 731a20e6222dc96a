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
"""Bank and force that the aircraft gives at most, where that is less than was told.

An autopilot may limit the bank more than the controller knows, and an engine may fail. Plans that
count on what is not there end in a limit cycle or below the stall speed.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from uav_tracking_mpc.control.event import EventLog, Level
from uav_tracking_mpc.dynamics.air import GRAVITY
from uav_tracking_mpc.dynamics.frames import bank_from_turn_rate
from uav_tracking_mpc.dynamics.vehicle import air_velocity, followed
from uav_tracking_mpc.estimation.measurement import Measurement
from uav_tracking_mpc.parameters.specification import changed
from uav_tracking_mpc.settings.tracking import TrackingParameters

LONGEST_GAP = 0.5  # s between two commands; after a longer one it begins anew
SHORTEST, LONGEST = 2.0, 5.0  # s, of a span
AT_LIMIT = 0.9  # -, share of what was told that counts as all of it
LEAST_GAIN = 0.4  # -, of a channel that follows
ASKED_SHARE = 0.4  # -, of what is asked for beyond a ceiling: if it is given, there is more
RISE = 5.0  # -, times the tolerance, by which more must be asked for
LEVEL = 0.25  # m/s^2, of force that is always counted on: without it no level orbit is left


class Scale(NamedTuple):
    """By how much a ceiling shows.

    Attributes:
        missing: What is asked for and not given, integrated, in the quantity's unit times [s].
        same: Tolerance of what is given, in the quantity's unit.
        more: By how much more than the ceiling may be asked for, likewise: if nearly half of it is
            given, there is more.
        step: By how much more than what is given then the ceiling rises, likewise.
        peak: By how much what is given may pass its mean meanwhile, likewise: gusts turn an
            aircraft both ways, a limit is never passed.
        least: The least ceiling, likewise: no autopilot banks by less, but in a gust, or by a plan
            that comes late, an aircraft does.
    """

    missing: float
    same: float
    more: float
    step: float
    peak: float
    least: float


BANK = Scale(0.14, 0.02, 0.02, 0.1, 0.06, 0.15)  # rad s, and rad
# m/s, and m/s^2: within a span a force changes with every gust, peaks say nothing
FORCE = Scale(2.0, 0.25, 0.6, 0.6, math.inf, -math.inf)


class _Span(NamedTuple):
    asked: float  # mean, in the quantity's unit
    given: float
    lacks: bool  # whether so much less was given, and no more for a moment


class Ceiling:
    """The most of a quantity that is given.

    It shows in two spans of time, in both of which less is given than asked for: by so much that no
    gain explains it; or in the second as much as in the first, although more is asked for than in
    the first, or all that was told. A span in which more is given for a moment shows none. If more
    is given after all, it rises beyond that; if what it has risen by is asked for and not given, it
    falls back to what is.

    Args:
        scale: Of the quantity.

    Attributes:
        most: The ceiling in the quantity's unit; inf while there is none.
    """

    def __init__(self, scale: Scale) -> None:
        self._scale = scale
        self.most = self._gave = math.inf  # the latter when it rose
        self.interrupt()

    def interrupt(self) -> None:
        """Begin a new span: what was before says nothing of what comes."""
        self._time = self._followed = math.nan
        self._before: _Span | None = None
        self._begin()

    def _begin(self) -> None:
        self._sums = [0.0] * 4  # of 1, of what is asked for, and of what is given, twice
        self._peak = -math.inf

    def see(
        self,
        time: float,
        asked: float,
        given: tuple[float, float],
        told: float,
        delay: float,
        gusts: float = 0.0,
    ) -> bool:
        """Take in a sample.

        Args:
            time: In [s].
            asked: What is commanded from now on, in the quantity's unit.
            given: Mean since the sample before, likewise, as measured in two ways, of which that
                with the greater mean of a span counts.
            told: The most that was told, in the quantity's unit.
            delay: Lag plus dead time in [s].
            gusts: Intensity of the random walk that gusts make of the integral of what is given, in
                the square of the quantity's unit times [s].

        Returns:
            Whether the ceiling has changed.
        """
        elapsed = time - self._time
        if not 0.0 < elapsed <= LONGEST_GAP:
            self.interrupt()
            self._time, self._followed = time, asked
            return False
        self._followed += followed(elapsed, delay) * (asked - self._followed)
        self._time = time
        values = zip(self._sums, (1.0, self._followed, *given), strict=True)
        self._sums = [sum_ + elapsed * value for sum_, value in values]
        self._peak = max(self._peak, *given)
        lasted, wanted, *had = self._sums
        lacks = wanted - max(had) >= self._scale.missing + math.sqrt(gusts * lasted)
        if lasted < (SHORTEST if lacks else LONGEST):
            return False
        mean = max(had) / lasted
        now = _Span(wanted / lasted, mean, lacks and self._peak <= mean + self._scale.peak)
        before = self._before
        self._begin()
        found = before is not None and self._judge(before, now, told)
        if found or before is None or not self._goes_on(before, now):
            self._before = now
        return found

    def _goes_on(self, before: _Span, now: _Span) -> bool:
        """Whether less was given than asked for in both spans, and the same."""
        return before.lacks and now.lacks and abs(now.given - before.given) <= self._scale.same

    def _judge(self, before: _Span, now: _Span, told: float) -> bool:
        """Whether two spans change the ceiling."""
        same = self._scale.same
        if now.given > self.most + ASKED_SHARE * self._scale.more:
            self.most, self._gave = now.given + self._scale.step, now.given
            if self.most + self._scale.more >= told:
                self.most = math.inf
            return True
        spans = before, now
        beyond = all(
            span.lacks and span.asked > max(0.0, span.given / LEAST_GAIN) for span in spans
        )
        pushed = now.asked > min(before.asked + RISE * same, AT_LIMIT * told)
        risen = now.given >= self._gave - same
        shows = beyond or ((pushed or risen) and self._goes_on(before, now))
        if not shows or now.given < self._scale.least or abs(now.given - self.most) <= same:
            return False
        self.most = now.given
        return True


class Authority:
    """Finds both ceilings and tells them.

    Args:
        events: Where to tell.
    """

    def __init__(self, events: EventLog) -> None:
        self._events = events
        self.reset()

    def reset(self) -> None:
        """Forget what was found: another aircraft, or one of which something else was told."""
        self._bank, self._force, self._side = Ceiling(BANK), Ceiling(FORCE), 0.0
        self._time, self._airspeed, self._ground = -math.inf, 0.0, [0.0] * 3
        self._told = ["", ""]

    def interrupt(self) -> None:
        """Keep what was found, but begin anew to look."""
        self._bank.interrupt()
        self._force.interrupt()

    def see(
        self,
        measurement: Measurement,
        air: Sequence[float],
        inputs: Sequence[float],
        told: TrackingParameters,
        delays: Sequence[float],
        gusts: float,
    ) -> bool:
        """Take in a measurement and the command that answers it.

        Args:
            measurement: Of the aircraft.
            air: (psi, chi, v) of the velocity through the air, shape (3,), in [rad] and [m/s].
            inputs: (u_psi, u_chi, u_v) at the aircraft's gains, shape (3,), in [rad/s] and [m/s^2].
            told: With the limits that were told.
            delays: Lag plus dead time of each channel in [s].
            gusts: Intensity of level gusts in [m^2/s^3].

        Returns:
            Whether a ceiling has changed.
        """
        (heading, path_angle, airspeed), time = air, measurement.stamp
        side = math.copysign(1.0, inputs[0])
        if side != self._side:
            self._bank.interrupt()
            self._side = side
        asked = -side * bank_from_turn_rate(inputs[0], airspeed)
        given = -side * bank_from_turn_rate(measurement.turn_rate, airspeed)
        found = self._bank.see(time, asked, (given, given), told.bank_max, delays[0])
        # By the velocity over ground as well, for a gust changes the airspeed at once.
        along, ground = air_velocity(heading, path_angle, 1.0, math), measurement.ground_velocity
        changes = zip(ground.tolist(), self._ground, along, strict=True)
        over_ground = sum((now - before) * share for now, before, share in changes)
        gained, elapsed = airspeed - self._airspeed, time - self._time
        self._time, self._airspeed, self._ground = time, airspeed, ground.tolist()
        if told.vehicle.commanded > 2 and elapsed > 0.0:
            weight = GRAVITY * math.sin(path_angle)
            _, most = told.envelope.force_limits(airspeed)
            force = gained / elapsed + weight, over_ground / elapsed + weight
            found |= self._force.see(time, inputs[2] + weight, force, most, delays[2], gusts)
        return found

    def within(self, asked: TrackingParameters) -> TrackingParameters:
        """Parameters whose limits are no more than the ceilings, where that leaves the orbit.

        Args:
            asked: What the user wants.
        """
        bank, force = self._bank.most, self._force.most
        least = max(force + FORCE.more, LEVEL)
        limits = {
            "bank_max": (bank, min(asked.bank_max, bank + BANK.more)),
            "force_max": (force, tuple(min(each, least) for each in asked.force_max)),
        }
        question = ": does the engine run?" if force < LEVEL else ""
        words = (
            f"the aircraft banks by {math.degrees(bank):.0f} deg at most, less than bank_max",
            f"the aircraft gives {force:.1f} m/s^2 at most, less than force_max{question}",
        )
        for index, (name, (most, value)) in enumerate(limits.items()):
            told = ""
            if not math.isinf(most):
                told = words[index]
                try:
                    asked = changed(asked, {name: value})
                except Exception as error:  # whatever a limit of somebody's raises
                    told += f"; plans count on more, for {error}"
            self._tell(index, told, name)
        return asked

    def _tell(self, index: int, words: str, name: str) -> None:
        """Tell a ceiling once, and its end."""
        if words and not self._told[index]:
            self._events.add(Level.WARNING, words)
        elif self._told[index] and not words:
            self._events.add(Level.INFO, f"the aircraft gives all of {name} again")
        self._told[index] = words
