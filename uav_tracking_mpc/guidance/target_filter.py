r"""Where the target is and will be: a Kalman filter on measured positions.

R. A. Singer, "Estimating Optimal Tracking Filter Performance for Manned Maneuvering Targets",
IEEE Trans. Aerospace and Electronic Systems 6(4), 1970: on each axis p' = v, v' = a and

.. math:: a' = -a / \tau + w, \quad E[w(t) w(s)] = (2 \sigma_a^2 / \tau)\, \delta(t - s)

so that the acceleration has standard deviation sigma_a and is forgotten after tau. Only positions
that the filter can believe are taken in: one whose innovation is improbable is left out, unless
the next ones agree with it. Then the target has jumped, or turned harder than it may, and the
filter starts anew from them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from uav_tracking_mpc.guidance.target_prediction import TurningTarget
from uav_tracking_mpc.guidance.target_track import TargetTrack

JUMP = 3  # positions left out in a row that agree with each other


@dataclass(frozen=True)
class TargetEstimate:
    """What is known of the target at one time.

    Attributes:
        position: In ``map``, shape (3,), in [m].
        velocity: Shape (3,), in [m/s].
        acceleration: Shape (3,), in [m/s^2].
        position_std: Standard deviation of the position, each axis, in [m].
    """

    position: NDArray[np.float64]
    velocity: NDArray[np.float64]
    acceleration: NDArray[np.float64]
    position_std: float
