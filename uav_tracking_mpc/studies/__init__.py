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

"""What studies the controller; nothing that flies imports it.

=====================  ===========================================================================
``comparison``         the predictive controller beside other laws, through the same scenarios
``campaign``           many flights of what is uncertain, and how many of them fail
``margins``            stability margins of the loop about the orbit, and weights that keep them
``identification``     lag, dead time, gain and limits of each channel from a recorded flight
``stability``          the paper's stability analysis, recomputed and proved
``feasibility_study``  what is guaranteed with an artificial orbit, and flights that show it
``benchmark``          solve times beside other solvers
``faults``             faults injected into real nodes, and on the wire to an autopilot
``study``              what a study found, to be printed and written
``executors``          work in processes of this machine or of a cluster
=====================  ===========================================================================
"""
