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

r"""How strong gusts are and how long they last: the Dryden model (MIL-F-8785C, low altitude).

With W20 the wind speed at 20 ft and h the height in feet, from 10 to 1000,

.. math:: \sigma_w = 0.1\, W_{20},\quad
          \sigma_u = \sigma_v = \sigma_w / (0.177 + 0.000823\, h)^{0.4},\quad
          L_w = h,\quad L_u = L_v = h / (0.177 + 0.000823\, h)^{1.2}.
"""

from __future__ import annotations

from typing import NamedTuple

FOOT = 0.3048  # m
HEIGHTS = (10.0 * FOOT, 1000.0 * FOOT)  # m, where the model holds; beyond, its value there


class GustScales(NamedTuple):
    """Strengths and lengths of gusts.

    Attributes:
        level: sigma_u = sigma_v in [m/s].
        vertical: sigma_w in [m/s].
        long: L_u = L_v in [m].
        short: L_w in [m].
    """

    level: float
    vertical: float
    long: float
    short: float


def gust_scales(height: float, intensity: float) -> GustScales:
    """Strengths and lengths of gusts at a height; outside the model's, its value at the end.

    Args:
        height: Above ground in [m].
        intensity: W20 in [m/s].
    """
    lowest, highest = HEIGHTS
    height = min(max(height, lowest), highest)
    shape = 0.177 + 0.000823 * height / FOOT
    vertical = 0.1 * intensity
    return GustScales(vertical / shape**0.4, vertical, height / shape**1.2, height)
