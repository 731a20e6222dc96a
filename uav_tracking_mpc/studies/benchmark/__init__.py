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

"""The solver of this package beside others: same problems, same starts, one interleaved run.

====================  ====================================================================
``cases``             the problems, where they start, the random states of the cold starts
``solver_timing``     run every solver on a case; times and shares
``acados_peer``       acados, in a program of another interpreter
``acados_program``    that program
``benchmark_study``   all cases, a sweep over the horizon, missions a second
``start_timing``      from the start of a process to its first optimal plan
``benchmark_report``  table and figure
``node_latency``      three real nodes, from a state to its command, beside an echo
``timed_nodes``       nodes of one or several aircraft, and what is read of their processes
``echo``              the echo: the same messages, answered by nothing but their stamp
``timed_simulator``   the simulator's process, which sends it and keeps the times
``watched_latency``   the same without and with a page that shows the flight
``watched_page``      that page
``page_reader``       who reads it and renders nothing
``timed_controller``  the controller's process, which answers it
====================  ====================================================================
"""
