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

"""What holds for the problem with the artificial orbit, and flights that show it.

========================  ==============================================================
``guarantee``             what is guaranteed, why, and what is not: in words
``random_flights``        random states that an aircraft can be in
``feasibility_campaign``  closed loops from all of them: feasible, converged, falling cost
``feasibility_study``     the two together
========================  ==============================================================
"""
