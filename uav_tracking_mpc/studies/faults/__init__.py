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

"""Faults injected into flying nodes from a seeded schedule, and what must hold all the while.

====================  =========================================================================
``kinds``             the faults, one idea a file, and their base
``stream_fault``      bases of faults that strike messages
``message_fields``    fields of the messages that faults change
``catalogue``         every fault by its label
``schedule``          which faults come when, from a seed
``injection``         one fault under way
``injected_flight``   the flight that faults act on
``streams``           the topics that faults strike, on both sides of the relay
``fault_relay``       the node in the middle of every topic, which strikes the messages
``parameter_client``  set_parameters, from a process of its own
``invariants``        what must hold for every message
``recovery``          when the aircraft is back on its orbit
``resources``         memory, files and threads of the processes
``observer``          the node that hears every message and checks the invariants
``case_bag``          the messages of a case that failed
``fault_findings``    what came of every case, and in total
``timeline``          the campaign in one figure
``fault_campaign``    cases one after the other
--------------------  -------------------------------------------------------------------------
``soak``              hours of flight without faults: is the orbit held, does anything grow
====================  =========================================================================

Schedule, invariants, recovery, resources, findings and timeline know nothing of ROS.
"""
