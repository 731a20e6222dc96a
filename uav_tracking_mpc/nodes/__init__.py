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

"""ROS 2 nodes: parameters and messages in, one call, messages out.

=====================  =====================================================================
``uav_simulator``      the vehicle and its autopilot
``target_publisher``   where the target is
``autopilot_link``     a real aircraft in the simulator's place, read by a thread of its own
``vehicle_node``       what these two share: a vehicle's state out, commands in
``nmpc_controller``    messages to the controller, its commands to the vehicle
``controller_report``  what it says: in the log, as diagnostics, on topics for people
``monitor``            a live table in the terminal
``flight_recorder``    every topic of a flight, into an MCAP bag
``bag_log``            the log of a flight from its bag, and what its nodes complained of last
``watching``           every aircraft of a domain, and requests to the nodes of one
``topics``             names, types and qualities of service; what may stand in a message
``messages``           room: arrays to messages and back
``ros``                room: what every node needs of ROS
=====================  =====================================================================
"""
