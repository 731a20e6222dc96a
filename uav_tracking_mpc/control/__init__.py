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
``guidance``         what the parameters ask for: an optimal control problem, or a law
``bank_alone``       a law where the autopilot holds altitude and airspeed
``fallback``         the modes from the optimal plan down to silence, and their choice
``command_shaping``  commands inside their limits, faded from one guidance to another
``excitation``       a small test signal, from which the aircraft's answer is identified
``command``          what the controller answers
``adaptation``       flies by the response that the aircraft shows
``oscillation``      tells limit cycles, and why
``limit_cycle``      notices one
``event``            what it reports
``direction``        which way round
``orbit_shortfall``  tells when another orbit is flown than the one asked for
``planned_path``     where a plan leads
``commanded_path``   where a command leads
``pace``             when a command is due
``plan_memory``      what is left of the last plan
``rate_keeper``      whether the control rate is kept
``record``           what a controller was given, to be flown again
``compiled_flight``  where the machine code is kept that is flown by
``certification``    what may be claimed of the terminal set that is flown
``claim_watch``      the same while the orbit changes in flight
``latest_job``       work in a thread of its own, of which only the latest counts
``orbit_deviation``  motion near the orbit, linearised at one azimuth
``sampled_loop``     lag, dead time, prediction and a static gain as a sampled loop
``orbit_loop``       that of the controller: its answers near the orbit
``loop_margins``     gain, phase, delay and disk margins of a loop
``margin_check``     whether they are as large as is asked, in words
===================  ===================================================================
"""
