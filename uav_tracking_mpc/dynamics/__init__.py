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

"""What flies: the vehicle (3), its motion relative to a target (9)-(12), angles and frames.

=====================  =====================================================================
``frames``             REP-103: ENU, FLU, quaternions, angles, signs on the wire
``angles``             old name of ``frames``
``vehicle``            (3): velocity of the air path, state under held inputs; how it responds
``paper_numbers``      Table 1, (59) and the initial state of the paper
``orbit``              the reference (r_d, z_d, v_d), and its motion in a drift
``energy_hold``        an autopilot that holds altitude and airspeed by its energy
``air``                gravity, the standard atmosphere, strengths and lengths of gusts
``geodesy``            latitude and longitude to the axes of ``map``, and back
``vehicle_models``     models of the aircraft for the prediction
``relative_models``    (9), (11) and the exact rates of (r, theta, z, chi, v)
``relative``           the coordinates (r, theta, z, chi, v), steady inputs, error form (11)
=====================  =====================================================================
"""
