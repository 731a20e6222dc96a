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

"""Faults injected from a seeded schedule, and what must hold all the while.

===================  ==========================================================================
``kinds``            the faults of nodes that fly, and their base
``stream_fault``     bases of faults that strike messages; the topics and fields that they strike
``schedule``         every fault by its label, and which come when, from a seed
``fault_campaign``   one fault under way; cases one after the other, whatever flies; what came of
                     them, as words and as a figure
``fault_relay``      the node in the middle of every topic, which strikes the messages
``invariants``       what must hold for every message, and when the orbit is reached again
``resources``        memory, files and threads of the processes
``observer``         the node that hears every message and checks the invariants
``node_campaign``    cases flown with real nodes, whose processes are watched; hours of flight
                     without any: is the orbit held, does anything grow
-------------------  --------------------------------------------------------------------------
``link_campaign``    faults on the wire to a simulated autopilot, one after the other
===================  ==========================================================================

Schedule, invariants, resources, campaign and all of the link know nothing of ROS. Link and
controller fly the simulated autopilot in simulated time, so that hours of faults take minutes.
"""
