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

"""Colours of the scene beside those of aircraft and modes, readable on white and on black."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.view.scene import Colour

GREY: Colour = (128, 128, 128)
FAINT: Colour = (150, 150, 150)
WIND: Colour = (86, 180, 233)
LIMIT: Colour = (213, 94, 0)


def paint(colour: Colour) -> NDArray[np.uint8]:
    """A colour for lines, points and arrows.

    Args:
        colour: Red, green, blue from 0 to 255.

    Returns:
        Shape (3,).
    """
    return np.array(colour, dtype=np.uint8)
