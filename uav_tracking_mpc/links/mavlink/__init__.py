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

======================  ==================================================================
``mavlink_link``        what all of them do alike
``listener``            everything that is heard of one autopilot
``dialect``             pymavlink and its messages
``connection``          bytes to messages and back
``wire``                sockets and serial ports that never block
``autopilot_clock``     the autopilot's clock by ours
``telemetry``           messages to measurements
``accuracies``          how accurate it says that they are
``flight_direction``    where it flies, from where the nose points
``vehicle_sighting``    a vehicle to circle that tells where it is
``vehicle_parameters``  parameters of the autopilot, read
``requests``            commands until they are acknowledged
``engagement``          who flies: pilot and autopilot, or our commands
``latency``             from telemetry in to the set-point that answers it
``findings``            what is looked at before a flight
``home_fence``          the autopilot's fence, as the controller and as an orbit see it
``arduplane_envelope``  what ArduPlane's parameters allow
``px4_envelope``        what PX4's parameters allow
``energy_law``          pitch and thrust, for autopilots that are told these
======================  ==================================================================
"""
