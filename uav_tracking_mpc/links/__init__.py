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

"""Links to what flies, one autopilot a file: measurements in, commands out.

================  ================================================================
``vehicle_link``  what every link does: the base, and what it raises and returns
``ardupilot``     ArduPlane in GUIDED, over MAVLink
``px4``           PX4 with a fixed wing in OFFBOARD, over MAVLink
``simulated``     a plant, as if it were behind a radio
``mavlink``       what autopilots on MAVLink share
================  ================================================================

A link is a subclass of :class:`VehicleLink` in a file of its own. It is found by its name, by an
entry point in the group ``uav_tracking_mpc.links``, or as ``path.py:Class``;
:func:`uav_tracking_mpc.links._check.check_link` tells its author whether it keeps what the base
asks for.
"""

from uav_tracking_mpc.links.vehicle_link import (
    Inspection,
    LinkError,
    LinkRefusedError,
    Sighting,
    VehicleLink,
)
from uav_tracking_mpc.parameters.registry import ExtensionPoint

__all__ = ["Inspection", "LinkError", "LinkRefusedError", "Sighting", "VehicleLink"]

VEHICLE_LINK = ExtensionPoint("vehicle link", VehicleLink)
