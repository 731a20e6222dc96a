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

"""What each input can be in a motion: all limits of the inputs together, as the span of a box.

Limits that meet on one input are merged smoothly. Plans like to stay where one limit takes over
from another; a kink there would leave Newton's method without a derivative.
"""

from __future__ import annotations

from collections.abc import Sequence
from types import ModuleType
from typing import Any

from uav_tracking_mpc.limits import Limit, Motion

# [rad/s], [rad/s], [m/s^2] over which limits merge
BLENDS = {"turn_rate": 0.02, "path_angle_rate": 0.02, "acceleration": 0.2}
# Of a blend, that an input can span where limits contradict each other: that named first wins.
LEAST_SPAN = 0.5


def input_span(
    limits: Sequence[Limit], numbers: Sequence[Any], motion: Motion, xp: ModuleType
) -> tuple[list[Any], list[Any]]:
    """Middle and half width of what each of (u_psi, u_chi, u_v) can be.

    Args:
        limits: All that hold.
        numbers: What each is told, shape (k,) or (k, n), see :meth:`Limit.numbers`.
        motion: In which the inputs are flown: scalars, or arrays of shape (n,).
        xp: ``casadi`` for expressions, ``numpy`` for numbers or arrays of them.

    Returns:
        Three values each, in [rad/s, rad/s, m/s^2], scalar or of shape (n,).
    """
    bounds = [limit.inputs(motion, told, xp) for limit, told in zip(limits, numbers, strict=True)]
    middle, half = [], []
    for name, blend in BLENDS.items():
        spans = [bound[name] for bound in bounds if name in bound]
        upper = _merged([span[1] for span in spans], blend, xp)
        if all(span[0] is None for span in spans):
            middle.append(0.0 * upper)
            half.append(upper)
            continue
        negative = [span[1] if span[0] is None else -span[0] for span in spans]
        lower = xp.fmin(-_merged(negative, blend, xp), spans[0][1] - LEAST_SPAN * blend)
        upper = xp.fmax(upper, lower + LEAST_SPAN * blend)
        middle.append(0.5 * (lower + upper))
        half.append(0.5 * (upper - lower))
    return middle, half


def _merged(values: list[Any], blend: float, xp: ModuleType) -> Any:
    least = values[0]
    for value in values[1:]:
        least = smooth_minimum(least, value, blend, xp)
    return least


def smooth_minimum(a: Any, b: Any, blend: float, xp: ModuleType) -> Any:
    """Smooth minimum, never above min(a, b), at most blend / 2 below it (where a = b).

    Args:
        a: In any unit [SI], scalar or any shape, or a symbol; so is b.
        b: The other value in [SI], any shape.
        blend: Difference of a and b over which they merge, in [SI].
        xp: ``casadi`` or ``numpy``.
    """
    return 0.5 * (a + b - xp.sqrt((a - b) ** 2 + blend**2))
