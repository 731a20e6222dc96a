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

"""Closed loop without ROS: a plant, a target and the controller, deterministic.

===================  ==============================================================
``closed_loop``      a plant and the controller, step by step
``flight_log``       what a flight leaves behind
``plants``           what can be flown, its inner loops and its sensors
``plan_follower``    the part of an autopilot that flies plans
``flight_dynamics``  six degrees of freedom: JSBSim with an airframe of ours
``wind``             mean wind and Dryden gusts
``motions``          how the target moves
``steered_target``   the target that is steered in flight, and how it is measured
===================  ==============================================================
"""
