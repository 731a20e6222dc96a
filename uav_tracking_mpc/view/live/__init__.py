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

"""Flights of ROS nodes: what is heard of them, and what can be asked of them.

================  ==================================================================================
``live_source``   flights over their topics
``live_sight``    what there is to see from what is heard
``ros_steering``  what a page can ask of a flight, asked of ROS nodes
================  ==================================================================================
"""
