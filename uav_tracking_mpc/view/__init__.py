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

"""The live page: a flight as a moving scene, with a panel to read and to steer it.

==================  ================================================================================
``sight``           what there is to see of one aircraft at one time
``watched_flight``  one aircraft that a page shows, and where such aircraft come from
``steering``        what a page can ask of a flight
``live``            flights of ROS nodes
``simulated``       a flight that is simulated in this process
``recorded``        flights that have been flown: logs and bags
``play_clock``      the time at which a flight is shown
``page``            the server: draws every aircraft of a source, twenty times a second
``guarded``         an element or a part whose exceptions end it alone
``serving``         who may open a page, and where it listens
``cameras``         from where each page looks
``appearance``      light or dark, and what the colours mean
``scene``           what is drawn, one file each
``panel``           what is read and steered, one file each
==================  ================================================================================

A page knows a flight by :class:`~uav_tracking_mpc.view.watched_flight.WatchedFlight` alone, whether
it is flown by ROS nodes, simulated in this process or recorded. viser serves it; the extra
``[view]`` installs that.
"""
