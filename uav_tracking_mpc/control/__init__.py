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

"""The controller, from a measurement to a command, and its fallback modes.

===================  ===================================================================
``controller``       the whole control step
``pace``             when a command is due, and whether the control rate is kept
``guidance``         what the parameters ask for: an optimal control problem, or a law
``fallback``         the modes from the optimal plan down to silence, and their choice
``command_shaping``  commands inside their limits, without jumps, and the test signal
``command``          what the controller answers
``commanded_path``   where a plan or a command leads
``adaptation``       flies by the response that the aircraft shows
``authority``        finds bank and force that the aircraft does not give
``softening``        makes a loop slower that swings, until it stops
``watches``          tells limit cycles, and another orbit or airspeed than asked for
``event``            what it reports
``record``           what a controller was given, to be flown again
``certification``    what may be claimed of the terminal set that is flown
``latest_job``       work in a thread of its own, of which only the latest counts
===================  ===================================================================
"""
