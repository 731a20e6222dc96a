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

"""Flights that have been flown: logs and bags.

=====================  =============================================================================
``logged_flight``      a flight from its log
``recorded_source``    all aircraft of a bag
``recorded_flight``    one of them, as what there is to see at a time
``recorded_figures``   what is read of each of its topics
``recorded_time``      time of such a flight: that of its stamps
``recorded_statuses``  what its nodes said of themselves
``recorded_topic``     messages of one topic, found by time
``bag_chunks``         chunks of a bag, unpacked when they are looked at
``bag_index``          where the messages of a bag lie
``recorded_scene``     a whole flight as a scene that needs no server
=====================  =============================================================================
"""
