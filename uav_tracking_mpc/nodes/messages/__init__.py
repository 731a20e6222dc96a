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

"""Messages to arrays and back.

=====================  ===============================================================
``conversions``        state, air velocity, target and commands, with their noise
``named_figures``      the orbit and what the controller tracks by, as figures by name
``diagnostic_values``  what nodes say of themselves: level, words, values, and some back
``heard_values``       what messages say to who only looks, live or from a bag
``wires``              odometry and commands as bytes, read and written in place
=====================  ===============================================================
"""
