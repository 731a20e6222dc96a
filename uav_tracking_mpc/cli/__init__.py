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

"""The ``uav_tracking`` command: one file a command, and what the commands share.

===================  =================================================================
``main``             entry point: chooses the command
``fly``              a mission with real ROS 2 nodes
``view``             a page that shows a flight, live or recorded, and steers it; how a page starts
``link``             what a real autopilot says before a flight
``simulate``         the same mission without ROS
``compare``          the predictive controller beside classical laws
``campaign``         random flights, and how many of them fail
``stability``        the stability analysis, its proof and its certificate
``margins``          stability margins about the orbit, and a search for weights
``benchmark``        solve times beside other solvers
``compile``          the solver of a configuration compiled before it flies
``identify``         lag, dead time and gain from a recorded flight
``torture``          faults injected into real nodes
``monitor``          a live table of a flight
``engage``           command of a flight, taken and given back; how its nodes are asked
``set``              parameters of a flight that is under way
``autopilot``        a simulated ArduPlane or PX4 behind MAVLink
``launch_tracking``  entry point of the executable that only starts the nodes
``node_programs``    entry points of the nodes' executables
``program``          what the commands share: parser, endings, printing and writing
``options``          options that several commands have, and what they choose
===================  =================================================================

A command's module holds ``HELP`` (one line), ``DESCRIPTION``, ``add_arguments(parser)`` and
``run(arguments)``, which returns the exit code. Whatever takes long to import is imported in
``run``, so that help comes at once.
"""
