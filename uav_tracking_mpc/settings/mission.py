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

"""What the commands add to the parameters of the nodes: the mission, and a scenario's words."""

from __future__ import annotations

from dataclasses import dataclass

from uav_tracking_mpc.dynamics import paper_numbers as paper
from uav_tracking_mpc.parameters.registry import PLANT
from uav_tracking_mpc.parameters.specification import Parameters, parameter


@dataclass(frozen=True)
class MissionParameters(Parameters):
    """What `fly` and `simulate` add to the nodes: how long, how fast, on which plant."""

    duration: float = parameter(
        paper.DURATION, "Length of the mission, simulated time.", "s", 1.0, 1e6
    )
    speed: float = parameter(
        10.0,
        "Simulated over wall time in fly and simulate --view; simulate alone is as fast as it can.",
        lower=0.01,
        upper=100.0,
    )
    plant: str = parameter(
        "vehicle",
        "What simulate flies: the exact vehicle in moving air, or euler, the prediction model "
        "itself advanced by Euler's method, which knows no wind and no lag.",
        extension=PLANT,
    )


@dataclass(frozen=True)
class ScenarioParameters(Parameters):
    """What a scenario is; no node reads it."""

    title: str = parameter("", "What it is called.")
    description: str = parameter("", "What happens in it.")
