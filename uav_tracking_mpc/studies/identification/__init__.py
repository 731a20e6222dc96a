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

"""Lag, dead time, gain and limits of each channel from a recorded flight.

==================  ======================================================================
``flight_record``   plans as they were flown, what was measured, of each channel; its files
``channel_fit``     maximum likelihood of lag, dead time, gain and limits
``identification``  all channels of a flight: intervals, table, YAML and figure
``validation``      how often all this is right, on simulated flights
==================  ======================================================================
"""
