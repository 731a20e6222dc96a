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

"""What can be set: the parameters of each part, described once, and configurations of them all.

=========================  ==================================================================
``tracking``               what the controller is asked to do
``estimation_parameters``  what it is told of delays and noise, and what it finds out by itself
``frame_parameters``       names of the coordinate frames
``simulator``              the simulated aircraft and its air
``target``                 how the simulated target moves and is measured
``link``                   which autopilot flies, where it is, what may be asked of it
``mission``                what the commands add to the nodes' parameters
``parameter_file``         YAML in the form that ROS 2 reads
``configuration``          one file for all of them, by name, checked
=========================  ==================================================================
"""
