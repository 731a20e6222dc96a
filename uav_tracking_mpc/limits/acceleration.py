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

"""Least and greatest acceleration."""

from __future__ import annotations

from dataclasses import dataclass
from types import ModuleType
from typing import Any

from uav_tracking_mpc.dynamics import paper_numbers as paper
from uav_tracking_mpc.limits import COMPILED, Limit, Motion
from uav_tracking_mpc.parameters.specification import parameter


@dataclass(frozen=True)
class Acceleration(Limit):
    """acceleration_min <= u_v <= acceleration_max."""

    name = "acceleration"

    acceleration_min: float = parameter(
        -paper.ACCELERATION_BOUND,
        "Least acceleration u_v.",
        "m/s^2",
        -100.0,
        -1e-3,
        fixed_unless=COMPILED,
    )
    acceleration_max: float = parameter(
        paper.ACCELERATION_BOUND,
        "Greatest acceleration u_v.",
        "m/s^2",
        1e-3,
        100.0,
        fixed_unless=COMPILED,
    )

    def inputs(self, motion: Motion, numbers: Any, xp: ModuleType) -> dict[str, tuple[Any, Any]]:
        """See :meth:`Limit.inputs`."""
        return {"acceleration": (numbers[0], numbers[1])}
