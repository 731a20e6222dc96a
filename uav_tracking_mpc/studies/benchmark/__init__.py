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

===================  ====================================================================
``benchmark_study``  solvers timed on the problems that are flown, a sweep over the horizon
``optimality``       cost and KKT residual of a plan, whoever found it
``start_timing``     from the start of a process to its first optimal plan
``node_latency``     three real nodes, from a state to its command, beside an echo or a page
===================  ====================================================================
"""
