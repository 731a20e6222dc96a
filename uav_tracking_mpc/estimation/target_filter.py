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

"""Where the target is and will be, from measured positions that may be wrong, late or missing.

How noisy the positions are (:class:`MeasurementNoise`) and how hard the target accelerates
(:mod:`~uav_tracking_mpc.estimation.target_track`) is found from the positions themselves; what is
told is only where both begin.

A position that the track can hardly explain is left out. Should the next ones be left out too and
agree with each other, then the target has jumped and the track starts anew from them. The noise is
learned from all positions, those left out as well: told far too small, it is corrected within a
second, and a good track is not left. Each axis has its own, where a covariance tells it or the axes
are seen to differ much.
"""

from __future__ import annotations

import math
from collections import deque

import numpy as np
from numpy.typing import ArrayLike, NDArray

from uav_tracking_mpc.estimation.measurement import MeasurementError, vector
from uav_tracking_mpc.estimation.motion_check import RETURN
from uav_tracking_mpc.estimation.state_gate import AGREEING, REPEATING
from uav_tracking_mpc.estimation.target_track import (
    FORGOTTEN,
    LEVEL,
    MANOEUVRE_TIME,
    REWIND,
    TURN,
    TargetTrack,
    track_step,
)
from uav_tracking_mpc.symbolic.native_code import NativeFunction, machine_code

GATE = 16.27  # -, chi-square of 3 degrees of freedom: one good position in a thousand is left out
RIVAL_SPEED = 2.0  # -, times the standard deviation of the velocity: it may be fast, not noisy
VELOCITY_NOISE = 1.0  # m/s, standard deviation of a velocity that comes without a covariance
NOISE_MIN = 1e-3  # m or m/s, the least standard deviation that is believed

# How noisy the positions are
WINDOW = 96  # second differences that count: noise of a camera turns with where it looks
NEWEST = 24  # of them, which notice that the noise has grown
CHANGED = 3.0  # ratio of the quantiles of newest and all: not by chance but once in a thousand
RATIO_MAX = 100.0  # -, of the intervals: an extrapolation any longer says little
QUANTILE = 0.4  # -, that is compared: with 20 % outliers half of the differences are wrong
CHI_SQUARE = 1.8691684  # -, that quantile, of 3 degrees of freedom
CHI_SQUARE_AXIS = 0.2749959  # -, the same of 1
# -: greatest variance over the least, from which on axes have factors of their own (by chance once
# in a thousand)
UNEVEN = 4.0
SCALE_MIN = 1e-12  # -, least factor on a variance that is believed, and 1 over the greatest


class TargetFilter:
    """Position, velocity and acceleration of a target from noisy measurements at any rate.

    Args:
        noise: Standard deviation of a measured position with which the filter begins in [m].
        agility: Standard deviation of the target's acceleration with which it begins in [m/s^2].
        speed: Standard deviation of the velocity before anything is known of it in [m/s].

    Attributes:
        noise: Standard deviation that was found of the newest measured position, on its worse level
            axis, in [m].
        rejected: Positions left out so far because the track could not explain them.
        late: Positions left out so far because they were not newer than the newest, by their
            stamp or because they are the same.
        jumps: How often the track started anew from positions that had been left out.
    """

    def __init__(self, noise: float, agility: float, speed: float = 5.0) -> None:
        self._told, self._agility, self._speed = noise, agility, speed
        self._turn = NativeFunction(TURN)
        machine_code(track_step())  # it takes too long when the first position comes
        self.reset()

    def tune(self, noise: float, agility: float) -> None:
        """Begin with other standard deviations; those that have been found are kept until then.

        Args:
            noise: Of a measured position in [m].
            agility: Of the target's acceleration in [m/s^2].
        """
        self._told, self._agility = noise, agility

    def reset(self) -> None:
        """Forget the target."""
        self._track: TargetTrack | None = None
        self._rival: TargetTrack | None = None  # of positions left out in a row
        self._last = np.zeros(3)  # that was not late
        self._scaling = MeasurementNoise()
        self._own = self._told  # the noise to which the scale belongs; 0 where covariances come
        self.noise = self._told
        self.rejected = self.late = self.jumps = 0

    @property
    def time(self) -> float | None:
        """Time of the newest position taken in, in [s]; None before the first."""
        return None if self._track is None else self._track.time

    @property
    def height(self) -> float | None:
        """Height in ``map`` where it was last seen in [m]; None before the first position."""
        return None if self._track is None else float(self._track.state[0, 2])

    @property
    def agility(self) -> float:
        """Standard deviation that was found of the target's acceleration in [m/s^2]."""
        return self._agility if self._track is None else self._track.agility

    def update(
        self,
        time: float,
        position: ArrayLike,
        velocity: ArrayLike | None = None,
        covariance: ArrayLike | None = None,
    ) -> bool:
        """Take in one measurement.

        Args:
            time: When it was measured in [s].
            position: In ``map``, shape (3,), in [m].
            velocity: In ``map``, shape (3,), in [m/s]; None if it is not known.
            covariance: Of position, shape (3, 3), or of position and velocity, shape (6, 6), in
                SI units; None, or a block of zeros, for the filter's own noise. Its diagonal
                counts, and more than it where the positions scatter more; a height without a
                variance is as uncertain as the worse of the others.

        Returns:
            False if it was left out: late, or not to be believed.

        Raises:
            MeasurementError: A value is not finite or not of its shape, or the covariance is
                negative; the filter is unchanged.
        """
        if not np.isfinite(time):
            raise MeasurementError(f"time of the target position is {time!r} s, must be finite")
        measured = vector("target position", position)
        told, velocity_variances = _variances(covariance)
        motion = None
        if velocity is not None:
            motion = vector("target velocity", velocity), velocity_variances
        newest = self._track if self._rival is None else self._rival
        if newest is not None and (time <= newest.time or self._repeats(time, measured)):
            self.late += 1
            return False
        self._last = measured
        variances = self._variances(time, measured, told)
        doubted = told is None and not self._scaling.known
        seen = time, measured, variances, GATE, motion, doubted

        def begun(speed: float) -> TargetTrack:
            return TargetTrack(time, measured, variances, self._agility, speed, motion, GATE)

        if self._track is None or time - self._track.time > FORGOTTEN:
            self._track, self._rival = begun(self._speed), None
            return True
        if self._track.update(*seen):
            self._rival = None
            return True
        if self._rival is None or not self._rival.update(*seen):
            self._rival = begun(RIVAL_SPEED * self._speed)
        elif self._rival.count == AGREEING:
            self._track, self._rival = self._rival, None
            self.jumps += 1
            return True
        self.rejected += 1
        return False

    def _repeats(self, time: float, position: NDArray[np.float64]) -> bool:
        """Whether an old position comes with a new stamp, as from a tracker that sends it on."""
        if self._track is None or self._rival is not None or time - self._track.time > REPEATING:
            return False
        velocity = self._track.state[1]
        moves = velocity @ velocity > GATE * self._track.variance(1)
        return bool(moves and np.array_equal(position, self._last))

    def _variances(
        self, time: float, position: NDArray[np.float64], told: NDArray[np.float64] | None
    ) -> NDArray[np.float64]:
        """Variances of a position on each axis in [m^2]: as told, as far as positions bear it out.

        Its own ones are corrected both ways, those of a covariance upwards alone.
        """
        own = self._own or self._told if told is None else 0.0
        if own != self._own:  # covariances come from now on, or no longer
            self._scaling = MeasurementNoise()
            self._own = own
        begun = np.full(3, own**2) if told is None else told
        self._scaling.see(time, position, begun)
        least = 0.0 if told is None else 1.0
        variances = np.maximum(begun * np.maximum(self._scaling.scales, least), NOISE_MIN**2)
        self.noise = math.sqrt(max(variances[LEVEL].tolist()))
        return variances

    def motion(self, time: float) -> NDArray[np.float64]:
        """Position [m], velocity [m/s], acceleration [m/s^2], in ``map``, rows of shape (3, 3).

        Args:
            time: In [s]: on from the newest position, where the velocity fades in the end, or up to
                a second back from it.

        Raises:
            ValueError: Nothing has been measured yet.
        """
        track = self.track
        travelled, left = track.bridge(time - track.time)
        motion, variance, turn_rate, lead = self._turn.arguments
        motion[:], variance[0], turn_rate[0] = track.state.flat, track.variance(2), track.turn_rate
        lead[0] = max(travelled, -REWIND)
        self._turn.evaluate()
        return self._turn.results[0].reshape(3, 3) * [[1.0], [left], [left * left]]

    @property
    def track(self) -> TargetTrack:
        """What is known of the target's motion.

        Raises:
            ValueError: Nothing has been measured yet.
        """
        if self._track is None:
            raise ValueError("no target position")
        return self._track


def _variances(
    covariance: ArrayLike | None,
) -> tuple[NDArray[np.float64] | None, NDArray[np.float64]]:
    """Variances of position [m^2], None for the filter's own, and of velocity [m^2/s^2]."""
    matrix = np.zeros((6, 6)) if covariance is None else np.asarray(covariance, dtype=float)
    if matrix.shape not in ((3, 3), (6, 6)) or not np.isfinite(matrix).all():
        raise MeasurementError(
            f"covariance of the target has shape {matrix.shape}, must be (3, 3) or (6, 6) and "
            "finite"
        )
    position, velocity = _of_axes(matrix[:3, :3]), _of_axes(matrix[3:, 3:])
    return position, np.full(3, VELOCITY_NOISE**2) if velocity is None else velocity


def _of_axes(covariance: NDArray[np.float64]) -> NDArray[np.float64] | None:
    """Variances of the axes, which must not be negative; some trackers tell none of the height."""
    if not covariance.any():
        return None
    east, north, up = np.diagonal(covariance).tolist()
    if not min(east, north) >= 0.0:
        raise MeasurementError(
            f"covariance of the target is {covariance.tolist()}, must not be negative"
        )
    return np.maximum([east, north, up if up > 0.0 else max(east, north)], NOISE_MIN**2)


class MeasurementNoise:
    r"""How noisy measured positions are, from the positions alone.

    The second difference of three positions z at intervals h_0 and h_1,

    .. math:: d = z_2 - z_1 - \rho (z_1 - z_0), \quad \rho = h_1 / h_0

    does not depend on where the target is and how fast. Its variance on an axis is R_2 + (1 +
    rho)^2 R_1 + rho^2 R_0, and as long as the target hardly accelerates in h_0 + h_1 nothing else
    is in it. With R = s R_told the factor s is a quantile of many squared second differences over
    the variance that is told, divided by that of chi-square: turns on the spot, jumps and outliers
    are rare and leave a quantile alone, and no filter that has lost the target misleads it.

    Where the axes differ much, as the height and the distance of many trackers do from the rest,
    each has a factor of its own, from the same quantile of its own squares. That takes more of
    them.

    Many of them make the factor accurate, few of them make it quick: the last hundred count,
    and the newest alone where they show that the noise has grown.

    Attributes:
        scales: The factor of each axis, 1 before anything is known, shape (3,), [-].
        known: Whether enough has been measured for the factors to be more than a guess.
    """

    def __init__(self) -> None:
        self._recent: deque[tuple[float, NDArray[np.float64], NDArray[np.float64]]] = deque(
            maxlen=2
        )
        # -: second differences by what is told on each axis, the first one of the usual size
        self._differences = np.full((1, 3), math.sqrt(CHI_SQUARE / 3.0))
        self._uneven = False
        self.scales, self.known = np.ones(3), False

    def see(
        self, time: float, position: NDArray[np.float64], variances: NDArray[np.float64]
    ) -> None:
        """Take in a position, whether or not a filter believes it.

        Args:
            time: When it was measured, after the one before, in [s].
            position: Shape (3,), in [m].
            variances: On each axis as they are told, shape (3,), in [m^2].
        """
        recent = self._recent
        if len(recent) == 2:
            (t0, z0, r0), (t1, z1, r1) = recent
            if time - t0 <= MANOEUVRE_TIME and time - t1 <= RATIO_MAX * (t1 - t0):
                ratio = (time - t1) / (t1 - t0)
                difference = position - z1 - ratio * (z1 - z0)
                told = variances + (1.0 + ratio) ** 2 * r1 + ratio * ratio * r0
                self._add(difference / np.sqrt(told))
        recent.append((time, position, variances))

    def _add(self, difference: NDArray[np.float64]) -> None:
        self._differences = np.vstack([self._differences, difference])[-WINDOW:]
        squares = self._differences**2
        sums = squares.sum(axis=1)
        level, recent = _quantile(sums), _quantile(sums[-NEWEST:])
        scales = np.full(3, (recent if recent > CHANGED * level else level) / CHI_SQUARE)
        if len(squares) == WINDOW:
            own = np.array([_quantile(axis) for axis in squares.T]) / CHI_SQUARE_AXIS
            noisiest = self._differences[:, own.argmax()]
            differ = own.max() > (RETURN if self._uneven else 1.0) * UNEVEN * own.min()
            # Noise goes up and down in turn, as no way of a target does.
            self._uneven = bool(differ and noisiest[:-1] @ noisiest[1:] < 0.0)
            scales = own if self._uneven else scales
        self.scales = np.clip(scales, SCALE_MIN, 1.0 / SCALE_MIN)
        self.known = len(squares) >= AGREEING  # with what is told


def _quantile(values: NDArray[np.float64]) -> float:
    """As NumPy's, in a tenth of its time for so few values."""
    ordered = sorted(values.tolist())
    at = QUANTILE * (len(ordered) - 1)
    share, low, high = at % 1.0, ordered[int(at)], ordered[math.ceil(at)]
    return low + share * (high - low) if share < 0.5 else high - (1.0 - share) * (high - low)
