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

"""What the paper prints, number by number: Table 1, (58)-(60) and the check of (41)."""

from __future__ import annotations

import numpy as np

PRINTED_A = np.array(
    [
        [1.0, 4.0, 0.0, 4.0, 0.0],
        [-0.0002, 1.0, 0.0001, -0.0302, 0.0075],
        [0.0, 0.0, 1.0, 4.0, 0.0],
        [0.0, 0.0, 0.0, 1.0, 0.0],
        [0.0, 0.0, 0.0, 0.0, 1.0],
    ]
)  # (58)
PRINTED_B = np.array(
    [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
)  # (58)
PRINTED_LEVEL_60 = 3.1733  # (60)
PRINTED_LEVEL_TABLE = 3.2649  # Table 1
PRINTED_LIPSCHITZ = 0.5265  # Table 1
PRINTED_LEFT_41 = 0.2782  # xi + (rho - 1) sigma
PRINTED_RIGHT_41 = 0.2762  # 2 L |A_K| + L^2


def symbolic_a(range_: float, altitude: float, speed: float, step: float) -> np.ndarray:
    """A of (12) evaluated, shape (5, 5).

    Args:
        range_: r_d in [m].
        altitude: z_d in [m].
        speed: v_d in [m/s].
        step: T_s in [s].
    """
    square = range_**2 - altitude**2
    a = np.eye(5)
    a[0, 1] = a[0, 3] = a[1, 0] = a[2, 3] = step * speed
    a[1, 2] = 2.0 * step * speed * range_ * altitude / square**2
    a[1, 3] = step * speed * range_ / square
    a[1, 4] = step * range_ / square
    return a
