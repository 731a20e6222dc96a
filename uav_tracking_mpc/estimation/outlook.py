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

r"""Target and drift from now on, from what the filters know of target and air.

The target goes on turning (:mod:`~uav_tracking_mpc.estimation.target_motion`); what its newest
measurement has changed fades in. The mean wind stays, the gust of now fades with its correlation
time T: at a time t from now, with wind w, gust g, the target's velocity v and acceleration a,

.. math:: c = w + e^{-t / T} g - v, \qquad c' = -e^{-t / T} g / T - a.
"""

from __future__ import annotations

import functools
from types import SimpleNamespace

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike, NDArray

from uav_tracking_mpc.estimation.target_motion import REWIND, TURN
from uav_tracking_mpc.symbolic.layout import Layout
from uav_tracking_mpc.symbolic.native_code import NativeFunction

# s: a measurement corrects the target's track by steps. They are faded in with this time constant,
# or those of a noisy track would go straight into the bank angle.
FADE_TIME = 1.0
TOLD = Layout(
    motion=9, variance=1, turn_rate=1, travelled=1, left=1, faded=6,
    wind=3, trend=3, gust=3, times=3,
)  # fmt: skip


class Outlook:
    """Evaluates target and drift at several times in one call.

    Args:
        count: n, how many times.
    """

    def __init__(self, count: int) -> None:
        self._function, self._count = NativeFunction(_function(count)), count

    def __call__(
        self,
        motion: ArrayLike,
        track: ArrayLike,
        faded: ArrayLike,
        air: tuple[ArrayLike, ArrayLike, ArrayLike, ArrayLike],
        times: ArrayLike,
    ) -> NDArray[np.float64]:
        """Target and drift at times from now on.

        Args:
            motion: Position, velocity, acceleration of the target's track, shape (9,).
            track: Shape (4,): variance of that acceleration [m^2/s^4], turn rate [rad/s], and as of
                :func:`~uav_tracking_mpc.estimation.target_motion.bridged` the time travelled since
                the track's time [s] and the share of the velocity that is left [-].
            faded: What is not yet corrected of position [m] and velocity [m/s], shape (6,).
            air: Mean wind [m/s], its trend [m/s^2], gust [m/s] and its correlation times [s], shape
                (3,) each.
            times: From now on, shape (n,), in [s].

        Returns:
            The target's position in ``map`` [m], c [m/s] and c' [m/s^2], shape (3, n, 3).
        """
        told, ahead = self._function.arguments
        told[:], ahead[:] = np.concatenate([motion, track, faded, *air]), times
        self._function.evaluate()
        return self._function.results[0].reshape(self._count, 3, 3).swapaxes(0, 1).copy()


@functools.cache
def _function(count: int) -> ca.Function:
    """What :class:`Outlook` evaluates; to derive it takes fifty milliseconds."""
    told, parts = TOLD.symbol("told")
    times = ca.SX.sym("ahead", count)
    rows = ca.horzcat(*[_at(time, parts) for time in ca.vertsplit(times)])
    return ca.Function("outlook", [told, times], [rows], {"cse": True})


def _at(time: ca.SX, told: SimpleNamespace) -> ca.SX:
    """Target's position, c and c' at one time."""
    left = told.left
    lead = ca.fmax(told.travelled + left * time, -REWIND)
    position, velocity, acceleration = ca.vertsplit(
        TURN(told.motion, told.variance, told.turn_rate, lead), 3
    )
    share = ca.exp(-time / FADE_TIME)
    blowing = ca.exp(-time / told.times) * told.gust
    return ca.densify(
        ca.vertcat(
            position + share * told.faded[:3],
            told.wind + time * told.trend + blowing - left * velocity - share * told.faded[3:],
            told.trend - blowing / told.times - left**2 * acceleration,
        )
    )
