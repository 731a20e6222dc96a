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

How noisy the positions are and how hard the target accelerates is found from the positions
themselves (:mod:`~uav_tracking_mpc.estimation.measurement_noise`,
:mod:`~uav_tracking_mpc.estimation.target_track`); what is told is only where both begin.

A position that the track can hardly explain is left out. Should the next ones be left out too and
agree with each other, then the target has jumped and the track starts anew from them. The noise is
learned from all positions, those left out as well: told far too small, it is corrected within a
second, and a good track is not left. Each axis has its own, where a covariance tells it or the axes
are seen to differ much.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from uav_tracking_mpc.estimation.measurement import MeasurementError, vector
from uav_tracking_mpc.estimation.measurement_noise import MeasurementNoise
from uav_tracking_mpc.estimation.state_gate import AGREEING, REPEATING
from uav_tracking_mpc.estimation.target_motion import REWIND, TURN, bridged
from uav_tracking_mpc.estimation.target_track import LEVEL, Motion, TargetTrack, track_step
from uav_tracking_mpc.symbolic.native_code import NativeFunction, machine_code

GATE = 16.27  # -, chi-square of 3 degrees of freedom: one good position in a thousand is left out
RIVAL_SPEED = 2.0  # -, times the standard deviation of the velocity: it may be fast, not noisy
FORGOTTEN = 300.0  # s without a position after which nothing is left of the track
VELOCITY_NOISE = 1.0  # m/s, standard deviation of a velocity that comes without a covariance
NOISE_MIN = 1e-3  # m or m/s, the least standard deviation that is believed


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
        if self._track is None or time - self._track.time > FORGOTTEN:
            self._track, self._rival = self._begun(*seen[:3], motion, self._speed), None
            return True
        if self._track.update(*seen):
            self._rival = None
            return True
        if self._rival is None or not self._rival.update(*seen):
            self._rival = self._begun(*seen[:3], motion, RIVAL_SPEED * self._speed)
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
            self._scaling.reset()
            self._own = own
        begun = np.full(3, own**2) if told is None else told
        self._scaling.see(time, position, begun)
        scales = self._scaling.scales
        scaled = begun * (scales if told is None else np.maximum(scales, 1.0))
        variances = np.maximum(scaled, NOISE_MIN**2)
        self.noise = math.sqrt(max(variances[LEVEL].tolist()))
        return variances

    def _begun(
        self,
        time: float,
        position: NDArray[np.float64],
        variances: NDArray[np.float64],
        motion: Motion | None,
        speed: float,
    ) -> TargetTrack:
        """A track of one measurement."""
        track = TargetTrack(time, position, variances, self._agility, speed)
        if motion is not None:
            track.see_velocity(*motion, GATE)
        return track

    def position_std(self, time: float) -> float:
        """Standard deviation of the position on the worse level axis in [m].

        Args:
            time: When, in [s]; before the newest position that of the newest one stands in.

        Raises:
            ValueError: Nothing has been measured yet.
        """
        track = self.track
        return track.position_std(min(max(time - track.time, 0.0), FORGOTTEN))

    def motion(self, time: float) -> NDArray[np.float64]:
        """Position [m], velocity [m/s], acceleration [m/s^2], in ``map``, rows of shape (3, 3).

        Args:
            time: In [s]: on from the newest position, where the velocity fades in the end, or up to
                a second back from it.

        Raises:
            ValueError: Nothing has been measured yet.
        """
        track, (travelled, left) = self.track, self.bridge(time)
        motion, variance, turn_rate, lead = self._turn.arguments
        motion[:], variance[0], turn_rate[0] = track.state.flat, track.variance(2), track.turn_rate
        lead[0] = max(travelled, -REWIND)
        self._turn.evaluate()
        return self._turn.results[0].reshape(3, 3) * [[1.0], [left], [left * left]]

    def bridge(self, time: float) -> tuple[float, float]:
        """See :func:`bridged`, from the time of the track on.

        Args:
            time: Now in [s].

        Raises:
            ValueError: Nothing has been measured yet.
        """
        track = self.track
        return bridged(min(time - track.time, FORGOTTEN), track.held)

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
    position, velocity = None, np.full(3, VELOCITY_NOISE**2)
    if covariance is None:
        return position, velocity
    matrix = np.asarray(covariance, dtype=float)
    if matrix.shape not in ((3, 3), (6, 6)) or not np.isfinite(matrix).all():
        raise MeasurementError(
            f"covariance of the target has shape {matrix.shape}, must be (3, 3) or (6, 6) and "
            "finite"
        )
    if matrix[:3, :3].any():
        position = _of_axes(matrix[:3, :3])
    if matrix[3:, 3:].any():
        velocity = _of_axes(matrix[3:, 3:])
    return position, velocity


def _of_axes(covariance: NDArray[np.float64]) -> NDArray[np.float64]:
    """Variances of the axes, which must not be negative; some trackers tell none of the height."""
    east, north, up = np.diagonal(covariance).tolist()
    if not min(east, north) >= 0.0:
        raise MeasurementError(
            f"covariance of the target is {covariance.tolist()}, must not be negative"
        )
    return np.maximum([east, north, up if up > 0.0 else max(east, north)], NOISE_MIN**2)
