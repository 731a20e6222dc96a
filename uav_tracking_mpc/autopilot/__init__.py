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
``airframe``             the plant, with attitude, ground and take-off run
``thrust``               throttle to specific force and back
``loiter``               a circle that the autopilot flies by itself, and the bank onto it
``flight_loops``         bank, climb and airspeed to the plant's inputs
``numbers``              numbers of MAVLink that the core speaks
``wire_traits``          how dialects differ on the wire
``onboard_parameters``   parameters as an autopilot keeps them
``autopilot_core``       an aircraft with modes and failsafes, stepped, without a wire
``dialects``             ArduPlane and PX4, one a file
-----------------------  -------------------------------------------------------------------------
``message_builders``     telemetry from the state of the core
``message_rates``        which messages are due
``vehicle_protocol``     what is answered to messages: commands, parameters, time
``radio``                the wire, on which faults act
``wire_faults``          the faults, by name
``ground_vehicle``       a second vehicle, to be circled
``wired_autopilot``      an autopilot and its wire
``simulated_autopilot``  all of it in real time, in a thread
``stepped_autopilot``    all of it in simulated time, step by step
=======================  =========================================================================

The files above the line know nothing of pymavlink.
"""
