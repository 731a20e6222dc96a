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

"""Names of the coordinate frames in messages, as parameters."""

from __future__ import annotations

from dataclasses import dataclass

from uav_tracking_mpc.parameters.specification import Parameters, parameter

NAMESPACE = "auto"  # as frame_prefix: the namespace of the node


@dataclass(frozen=True)
class MapFrameParameters(Parameters):
    """Of every node that reads or writes positions."""

    map_frame: str = parameter("map", "Frame of all positions: ENU (REP-103, REP-105).", fixed=True)


@dataclass(frozen=True)
class FrameParameters(MapFrameParameters):
    """Of every node that reads or writes the aircraft's state."""

    base_frame: str = parameter(
        "base_link", "Frame of the aircraft: FLU, without its prefix.", fixed=True
    )
    frame_prefix: str = parameter(
        NAMESPACE,
        f"Put before base_frame. {NAMESPACE}: the node's namespace, such as uav1/, so that two "
        "aircraft do not share a frame; nothing where it has none.",
        fixed=True,
    )
