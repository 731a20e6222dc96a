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

"""Faults on the wire to an autopilot, and what must hold all the while.

Link and controller fly the simulated autopilot in simulated time, so that hours of faults take
minutes and a case can be seen again. Nothing here needs ROS.

====================  =========================================================================
``link_flight``       controller, link and autopilot, step by step
``sent_messages``     what must hold for every message that is sent to the autopilot
``link_fault_kinds``  the wire's faults, and what pilots and companions do
``bad_frames``        frames that are none, and what a connection makes of them
``link_campaign``     faults one after the other, and what came of each
====================  =========================================================================
"""
