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

"""Nodes as processes: started, watched over and ended.

=====================  ==========================================================================
``domain``             a ROS domain of one's own
``shared_memory``      files of Fast DDS that a killed process leaves behind
``node_process``       one node as a process that cannot outlive its launcher
``supervisor``         all node processes of a flight: started, frozen, killed, restarted, ended
``flight``             one flight with real nodes, recorded
``fleet``              several aircraft under one launch file of ROS 2: namespaces, starts, views
``simulated_pace``     how fast simulated time runs while the solver is being compiled
``controller_kill``    the service that kills the controller and starts it again
``preflight``          what a real autopilot says before, and the envelope that follows
``autopilot_process``  an autopilot of our own behind a wire, where there is no other
``page_process``       the page of a flight as a process of its own
=====================  ==========================================================================
"""
