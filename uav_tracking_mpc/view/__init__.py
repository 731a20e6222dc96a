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

======================  ===========================================================================
``sight``               what there is to see of one aircraft at one time
``watched_flight``      one aircraft that a page shows, and where such aircraft come from
``steering``            what a page can ask of a flight
``ros_steering``        the same, asked of ROS nodes
``play_clock``          the time at which a recorded flight is shown
``logged_flight``       a flight from its log
``live_source``         flights over their topics
``live_sight``          what there is to see from what is heard
``cameras``             from where each page looks
``appearance``          light or dark, and what the colours mean
``simulated_source``    a flight that is simulated in this process, and its thread
``interrupted_loop``    a closed loop with faults
``simulated_sight``     what there is to see of it
``simulated_status``    what its parts say of themselves
``simulated_steering``  what can be asked of it
``request_queue``       requests of other threads, done between two ticks
``recorded_scene``      a whole flight as a scene that needs no server
``recorded_source``     all aircraft of a bag
``recorded_flight``     one of them, as what there is to see at a time
``recorded_figures``    what is read of each of its topics
``recorded_time``       time of such a flight: that of its stamps
``recorded_statuses``   what its nodes said of themselves
``recorded_topic``      messages of one topic, found by time
``bag_chunks``          chunks of a bag, unpacked when they are looked at
``bag_index``           where the messages of a bag lie
``page``                the server: draws every aircraft of a source, twenty times a second
``guarded_server``      viser's server, which answers to whom it should
``access``              who may open a page
``listening``           the socket at which a page listens, and its address
``browser``             opens a page where there is a screen
``scene``               what is drawn, one file each
``panel``               what is read and steered, one file each
======================  ===========================================================================

A page knows a flight by :class:`~uav_tracking_mpc.view.watched_flight.WatchedFlight` alone, whether
it is flown by ROS nodes, simulated in this process or recorded. viser serves it; the extra
``[view]`` installs that.
"""
