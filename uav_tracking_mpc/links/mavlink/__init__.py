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

"""What the links to autopilots on MAVLink share.

====================  ===================================================================
``mavlink_link``      what all of them do alike, and how quickly they answer telemetry
``listener``          everything that is heard of one autopilot, and of a vehicle to circle
``dialect``           pymavlink and its messages
``connection``        sockets and serial ports that never block; bytes to messages and back
``telemetry``         messages to measurements by our clock, and how accurate these are
``requests``          commands until they are acknowledged; parameters, read
``engagement``        who flies: pilot and autopilot, or our commands
``findings``          what is looked at before a flight, and the autopilot's fence
``energy_law``        pitch and thrust, for autopilots that are told these
====================  ===================================================================
"""
