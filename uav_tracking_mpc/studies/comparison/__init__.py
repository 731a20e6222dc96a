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

"""The predictive controller beside other laws, through scenarios and under mismatches.

=============  =====================================================================
``scenarios``  laws, scenarios and mismatches by name, sensors that fail among them
``measures``   what counts of a flight
``asked``      what is to be reached of it
``results``    every law flown through each: as one object, as JSON and as a table
``figures``    the comparison as a study: pictures, and the page that holds them
=============  =====================================================================
"""
