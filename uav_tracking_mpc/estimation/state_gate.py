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

"""Which measurements are believed: an odd one is an outlier, several that agree are a fact."""

from __future__ import annotations

import math
from collections import deque
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.estimation.measurement import Measurement, MeasurementError

SPEED_LIMIT = 500.0  # m/s over ground; a faster change of position is a jump
FASTER = 2.0  # -, times the ground velocity before a gap, that explain a jump after it
JUMP_MIN = 50.0  # m; a smaller change of position is never a jump
NOISE_MULTIPLE = 6.0  # -, standard deviations of a position that are no jump and no climb either
# s after which a state that repeats itself, though the aircraft moves, is none; and in which the
# same position of a target that moves is an old one, sent again
REPEATING = 0.5
AGES = 20  # states in a row, of which the one that was the least old tells how the clocks differ
AGREEING = 3  # outliers in a row, each consistent with the one before, that are a fact
# m/s, m/s^2; rad, rad/s: what ground velocity and attitude change by at most where the aircraft
# flies on, and plus so much times the time between: its position alone is wrong then
SUDDEN, STEEPEST = 5.0, 30.0
TURNED, QUICKEST = 0.1, 1.5


class Verdict(Enum):
    """What to do with a measurement."""

    USE = "use"
    DROP = "drop"  # a duplicate, a repetition, or out of order: nothing to report
    DOUBT = "doubt"  # an outlier: not used unless the next ones agree
    RESTART = "restart"  # time has gone back, or the vehicle is elsewhere: start anew


class StateGate:
    """Judges measurements by stamp and position.

    Args:
        timeout: Step of the stamps, either way, that is no longer ordinary, in [s].
        checked: Whether positions are compared with the ground velocity afterwards: one that jumps
            while all else goes on is theirs then.

    Attributes:
        newest: The newest measurement that was believed; None before the first.
        lost: Whether the measurements are known to have ended; until one is believed again.
        reason: Why the last measurement was doubted or made a restart, in words.
    """

    def __init__(self, timeout: float, checked: bool = False) -> None:
        self.timeout, self.checked = timeout, checked
        self.newest: Measurement | None = None
        self._stood = np.zeros(3)  # m, flown by the ground velocity while the position repeated
        self._moved = math.nan  # when it last moved: [s] of the stamps
        self._ages: deque[float] = deque(maxlen=AGES)  # at their arrival in [s]
        self.lost = False
        self._outliers: list[Measurement] = []  # in a row, each consistent with the one before
        self.reason = ""

    def check_target(
        self, stamp: float, known: float | None, limit: float, now: float = math.nan
    ) -> None:
        """Refuse a target's stamp that is ahead; while no state comes there is nothing to compare.

        Args:
            stamp: By the same clock in [s].
            known: The target's newest stamp that was taken in [s]; None before the first.
            limit: By how much targets may be ahead while states do not come, in [s].
            now: Time at the call in [s], by the clock of the stamps; not a number if it is unknown.

        Raises:
            MeasurementError: It is ahead of the newest state and target, and of the clock, by more
                than the timeout; or of the state by more than the limit.
        """
        if self.newest is None or self.lost:
            return
        lead, allowed = stamp - self.newest.stamp, min(self.timeout, limit)
        step = lead if known is None else min(lead, stamp - known)
        late = self._ahead(stamp, now) <= allowed  # it is the state that is
        if (step > allowed and not late) or lead > limit:
            why = "no newer state has come" if late else "do the clocks agree?"
            raise MeasurementError(
                f"target: its stamp is {lead:.3f} s ahead of the vehicle's, may be {allowed:g} s: "
                f"{why}"
            )

    def judge(self, measurement: Measurement, now: float = math.nan) -> Verdict:
        """What to do with a measurement.

        Args:
            measurement: Stamp and position count, and the noise of the position where it is known.
            now: When it arrived in [s], by the clock of the stamps, which may be that of a
                simulation; not a number where that is unknown.
        """
        newest = self.newest
        if newest is None:
            return self._believe(measurement, now, Verdict.USE)
        step, jump = _change(newest, measurement, self._stood)
        if -self.timeout <= step <= 0.0:
            return Verdict.DROP
        if self.hangs(measurement):
            self.lost = self.lost or step > self.timeout
            return Verdict.DROP
        flown = FASTER * math.hypot(*newest.ground_velocity.tolist()) * abs(step)
        moved = jump > flown + _explained(measurement, min(abs(step), self.timeout))
        if self.checked and 0.0 < step <= self.timeout and _goes_on(newest, measurement, step):
            moved = False
        # A gap that the clock has seen as well is one of the messages, not of the stamps.
        ordinary = step > 0.0 and (
            step <= self.timeout or self._ahead(measurement.stamp, now) <= self.timeout
        )
        if ordinary and not moved:
            return self._believe(measurement, now, Verdict.USE)
        if step < 0.0:
            self.reason = f"the stamp went back by {-step:.3f} s"
        elif moved:
            self.reason = f"the position jumped by {jump:.6g} m in {step:.3f} s"
        else:
            self.reason = f"the stamp went ahead by {step:.3f} s"
        last = self._outliers[-1] if self._outliers else measurement
        later, apart = _change(last, measurement)
        agrees = 0.0 < later <= self.timeout and apart <= _explained(measurement, later)
        self._outliers = [*self._outliers, measurement] if agrees else [measurement]
        if len(self._outliers) < AGREEING:
            return Verdict.DOUBT
        # After a gap the flight goes on; time gone back and a vehicle elsewhere are a new beginning
        verdict = Verdict.RESTART if step < 0.0 or moved else Verdict.USE
        return self._believe(measurement, now, verdict)

    def hangs(self, measurement: Measurement) -> bool:
        """Whether states have only repeated themselves for some time, though they moved before.

        Args:
            measurement: The newest one.
        """
        repeats = self.newest is not None and _repeats(self.newest, measurement)
        return repeats and measurement.stamp - self._moved > REPEATING

    def _ahead(self, stamp: float, now: float) -> float:
        """By how much a stamp is ahead of the clock and what states were late at least in [s]."""
        return stamp - now + min(self._ages, default=math.nan)

    def _believe(self, measurement: Measurement, now: float, verdict: Verdict) -> Verdict:
        before, self.newest, self._outliers = self.newest, measurement, []
        if before is not None and not _repeats(before, measurement):
            self._moved = measurement.stamp
        if before is not None and before.position.tolist() == measurement.position.tolist():
            self._stood += (measurement.stamp - before.stamp) * measurement.ground_velocity
        else:
            self._stood[:] = 0.0
        self.lost = False
        self._ages.append(now - measurement.stamp)
        return verdict


def _change(
    before: Measurement, after: Measurement, flown: NDArray[np.float64] | float = 0.0
) -> tuple[float, float]:
    """Time [s] and distance [m] between two measurements.

    A position that repeats, or is not known, is no jump. After one that has repeated, the aircraft
    may have flown on, or have stood there, as it does while a simulation waits: the smaller
    distance counts.
    """
    step = after.stamp - before.stamp
    apart = after.position - before.position
    distance = math.hypot(*apart.tolist())
    if not distance > 0.0:  # also where it is no number
        return step, 0.0
    return step, min(distance, math.hypot(*(apart - flown).tolist()))


def _repeats(before: Measurement, after: Measurement) -> bool:
    """Whether nothing has changed but the stamp, though the aircraft moves: nobody measures."""
    return (
        before.heading == after.heading
        and before.path_angle == after.path_angle
        and before.position.tolist() == after.position.tolist()
        and before.ground_velocity.tolist() == after.ground_velocity.tolist()
        and any(after.ground_velocity.tolist())
    )


def _goes_on(before: Measurement, after: Measurement, step: float) -> bool:
    """Whether the aircraft flies on as before, whatever its position says."""
    change = math.hypot(*(after.ground_velocity - before.ground_velocity).tolist())
    turned = (
        math.remainder(after.heading - before.heading, math.tau),
        after.path_angle - before.path_angle,
        (after.bank or 0.0) - (before.bank or 0.0),
    )
    return change <= SUDDEN + STEEPEST * step and all(
        abs(angle) <= TURNED + QUICKEST * step for angle in turned
    )


def _explained(measurement: Measurement, step: float) -> float:
    """Greatest distance [m] that motion and noise explain in a time [s]."""
    return JUMP_MIN + NOISE_MULTIPLE * max(measurement.noise.position) + SPEED_LIMIT * step
