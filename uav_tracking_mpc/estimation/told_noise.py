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

"""What a source tells of its noise, as far as it makes sense; the rest is unknown.

Unknown are variances of which none is positive, one is negative or not finite, or one is so large
that it says nothing. An axis of 0 beside others that are known counts as their mean.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from uav_tracking_mpc.estimation.measurement import NOISE_LIMITS

UNKNOWN = (0.0, 0.0, 0.0)  # -, of any unit: nothing is told


def makes_sense(variances: Sequence[float]) -> bool:
    """Whether variances are of a covariance, and known.

    Args:
        variances: In any unit [SI].
    """
    # The sum is finite only if each of them is.
    return min(variances) >= 0.0 and 0.0 < sum(variances) < math.inf


def axes_noise(name: str, variances: Sequence[float]) -> tuple[float, float, float]:
    """Standard deviation of each axis, in its unit [SI]; zeros where unknown.

    Args:
        name: ``position`` or ``velocity``, as of :class:`SensorNoise`.
        variances: Of three axes, in the square of the unit [SI].
    """
    if not makes_sense(variances) or max(variances) > NOISE_LIMITS[name] ** 2:
        return UNKNOWN
    if 0.0 in variances:
        known = [variance for variance in variances if variance > 0.0]
        mean = sum(known) / len(known)
        variances = [variance or mean for variance in variances]
    x, y, z = variances
    return math.sqrt(x), math.sqrt(y), math.sqrt(z)


def scalar_noise(name: str, variance: float) -> float:
    """Standard deviation, in its unit [SI]; 0 where unknown.

    Args:
        name: Of the others of :class:`SensorNoise`.
        variance: In the square of the unit [SI].
    """
    return math.sqrt(variance) if 0.0 < variance <= NOISE_LIMITS[name] ** 2 else 0.0
