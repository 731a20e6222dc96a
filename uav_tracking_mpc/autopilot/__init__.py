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

"""A simulated autopilot: the product's plant behind a MAVLink server.

=======================  =========================================================================
``airframe``             the plant with attitude, ground and take-off run; throttle to force
``flight_loops``         bank, climb and airspeed to the plant's inputs; circles of its own
``autopilot_core``       an aircraft with modes, parameters and failsafes, without a wire
``arduplane``            ArduPlane: GUIDED, with altitude and airspeed held by itself
``px4``                  PX4 fixed wing: OFFBOARD, by attitude and thrust
``telemetry_messages``   telemetry from the state of the core, and which messages are due
``vehicle_protocol``     what is answered to messages: commands, parameters, time
``deliveries``           what may happen to a stream of messages or of bytes on its way
``wire_faults``          the wire, and its faults by name
``simulated_autopilot``  an autopilot and its wire: in real time in a thread, or stepped
=======================  =========================================================================
"""
