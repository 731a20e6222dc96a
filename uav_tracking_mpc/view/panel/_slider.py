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

"""Sliders of parameters: over what is sensible for a flight, inside what is allowed at all."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from uav_tracking_mpc.parameters.specification import Specification

if TYPE_CHECKING:
    import viser

STEPS = 150  # about so many from end to end


def add_slider(
    gui: viser.GuiApi, specification: Specification, value: float, least: float, most: float
) -> viser.GuiSliderHandle[float]:
    """Add a slider.

    Args:
        gui: Where to add it.
        specification: Of the parameter.
        value: That it has now in its unit [-].
        least: Sensible value in its unit [-].
        most: Sensible value in its unit [-].
    """
    allowed_least = -math.inf if specification.lower is None else specification.lower
    allowed_most = math.inf if specification.upper is None else specification.upper
    step = round_step((most - least) / STEPS)
    least = max(step * math.floor(least / step + 1e-9), allowed_least)
    most = min(step * math.ceil(most / step - 1e-9), allowed_most)
    label = specification.name.replace("_", " ")
    unit = f" [{specification.unit}]" if specification.unit else ""
    return gui.add_slider(
        label + unit,
        min=round(min(least, value), 9),
        max=round(max(most, value), 9),
        step=step,
        initial_value=value,
        hint=f"{specification.description} Allowed: {specification.allowed}.",
    )


def set_slider(slider: Any, value: float) -> None:
    """Set a slider, also beyond what it spanned.

    Args:
        slider: What is set.
        value: In the unit of the parameter [-].
    """
    if value < slider.min:
        slider.min = value
    if value > slider.max:
        slider.max = value
    slider.value = value


def round_step(step: float) -> float:
    """The least of 1, 2, 5, 10 and so on that is not smaller.

    Args:
        step: Positive [-].
    """
    decade = 10.0 ** math.floor(math.log10(step))
    return next(round(f * decade, 12) for f in (1.0, 2.0, 5.0, 10.0) if f * decade >= step * 0.999)
