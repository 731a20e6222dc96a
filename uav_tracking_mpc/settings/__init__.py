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

====================  ====================================================================
``tracking``          of both problems, of the estimators, and of the controller
``simulator``         the simulated aircraft and its air, the target, the mission
``link``              which autopilot flies, where it is, what may be asked of it
``frame_parameters``  names of the coordinate frames
``configuration``     one YAML file for all of them, in the form that ROS 2 reads, by name
====================  ====================================================================
"""
