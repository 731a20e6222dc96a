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

"""What every node needs of ROS.

=======================  =====================================================================
``process``              start, spin, stop, exit codes; a node in the background
``ros_environment``      domain, log folder, and why ROS does not start
``declared_parameters``  parameter dataclasses as ROS parameters
``endpoints``            publishers and subscriptions of topics, who is there; outages for trials
``diagnostics``          /diagnostics, its steady status, warnings, and whether two send
``managed_node``         a managed node: its transitions survived, its commands taken away
``node_reference``       what a node prints with --help, and the tables of the documentation
``rclpy_internals``      what rclpy keeps to itself and nodes need all the same
=======================  =====================================================================
"""
