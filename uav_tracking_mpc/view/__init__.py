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

=======================  ===========================================================================
``watched_flight``       an aircraft that a page shows: what there is to see and to ask
``snapshot``             what there is to see, built from what is measured or published
``live_source``          flights of ROS nodes
``simulated_source``     a flight that is simulated in this process
``simulated_steering``   how that is steered, its faults, and the classical laws beside it
``recorded_source``      flights of a bag
``recorded_scene``       a flight from its log, and all of it as a scene that needs no server
``flight_history``       all that was flown, thinned: what the time strip of a page draws
``visitors``             each open page: what its script asks for and is told, and its past
``page``                 the server: draws every aircraft of a source, twenty times a second, and
                         says what lines and colours mean
``serving``              who may open a page, and where it listens
``cameras``              from where each page looks
``scene``                what is drawn
``panel``                what is read and steered
=======================  ===========================================================================

A page knows a flight by :class:`~uav_tracking_mpc.view.watched_flight.WatchedFlight` alone, whether
it is flown by ROS nodes, simulated in this process or recorded. viser serves it; the extra
``[view]`` installs that.
"""
