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

"""What is known of aircraft, air and target.

=======================  =======================================================================
``measurement``          what is measured of the aircraft at one time, and told of its noise
``state_gate``           which measurements are believed
``air_data``             the airspeed that belongs to a measurement
``flight_path``          path through the air, from the attitude of the body
``air_estimate``         aircraft and air: three filters, two of which judge a sensor each
``motion_check``         which positions and ground velocities are believed
``air_check``            which airspeeds and headings are believed
``sensor_health``        which sensors are used, and why one is not
``rate_aided``           angles and speeds, from themselves and rates whose biases are taken out
``wind_filter``          mean wind, gusts and sensor biases, from positions and velocities
``noise_meter``          how noisy a signal is, and how much it wanders
``target_filter``        where the target is and will be, from positions that may be wrong
``target_track``         several models of the target's motion side by side, behind it
``response_estimator``   lag, dead time, gain and their deviations, from commands and response
``navigator``            measurements in, situations and forecast out
``situation``            aircraft, target and the drift between them, now and over a horizon
=======================  =======================================================================
"""
