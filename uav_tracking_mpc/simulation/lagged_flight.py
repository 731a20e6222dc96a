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

r"""The vehicle (3) while its rates still approach their commands.

Heading, path angle and airspeed are integrals of the rates, hence sums of exponentials in closed
form; only the position, the integral of :func:`~uav_tracking_mpc.dynamics.vehicle.air_velocity`, is
left to a quadrature, Gauss-Legendre with five points on panels that are short beside any turn.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from uav_tracking_mpc.dynamics.angles import wrap_angle
from uav_tracking_mpc.dynamics.vehicle import air_velocity
from uav_tracking_mpc.simulation.inner_loop import Channel

PANEL = 0.05  # s, longest
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(5)
POINTS = tuple(zip((0.5 * (1.0 + _NODES)).tolist(), (0.5 * _WEIGHTS).tolist(), strict=True))


def advance_lagged(
    state: Sequence[float], channels: tuple[Channel, Channel, Channel], duration: float
) -> tuple[float, float, float, float, float, float]:
    """State after ``duration``, with what each channel wants held.

    Args:
        state: (x, y, z, psi, chi, v), shape (6,), in [m], [rad] and [m/s].
        channels: Of turn rate, path-angle rate and acceleration; their rates are moved on.
        duration: In [s], positive.

    Returns:
        State at the end, shape (6,), angles wrapped to (-pi, pi].
    """
    x, y, z, psi, chi, v = state
    turn, climb, engine = channels
    count = math.ceil(duration / PANEL)
    step = duration / count
    for _ in range(count):
        for point, weight in POINTS:
            moment = point * step
            heading = psi + turn.integral(moment)
            path_angle = chi + climb.integral(moment)
            airspeed = v + engine.integral(moment)
            east, north, up = air_velocity(heading, path_angle, airspeed, math)
            x += weight * step * east
            y += weight * step * north
            z += weight * step * up
        psi, chi, v = (
            start + channel.integral(step)
            for start, channel in zip((psi, chi, v), channels, strict=True)
        )
        for channel in channels:
            channel.rate = channel.rate_after(step)
    if max(abs(psi), abs(chi)) >= math.pi:  # seldom, and slow
        psi, chi = wrap_angle([psi, chi]).tolist()
    return x, y, z, psi, chi, v
