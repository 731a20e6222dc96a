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

"""Stability margins of the loop that is flown, near its orbit.

================  ===================================================================
``orbit_loop``    the sampled loop near the orbit, from the controller's own answers
``loop_margins``  gain, phase, delay and disk margins of a loop
``margin_check``  whether they are as large as is asked, in words
================  ===================================================================
"""
