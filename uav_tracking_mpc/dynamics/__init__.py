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
``angles``             wrapping
``frames``             REP-103: ENU, FLU, quaternions, signs on the wire
``vehicle``            (3): velocity of the air path, and the state under held inputs, exact
``paper_numbers``      Table 1, (59) and the initial state of the paper
``orbit``              the reference (r_d, z_d, v_d) and its direction
``energy_hold``        an autopilot that holds altitude and airspeed by its energy
``flown_orbit``        the orbit that is flown, as an autopilot is told
``gravity``            standard gravity
``atmosphere``         density of the standard atmosphere, true over equivalent airspeed
``geodesy``            latitude and longitude to the axes of ``map``, and back
``response``           how an aircraft answers commands: lag, dead time and gain
``vehicle_models``     models of the aircraft for the prediction, one file each
``relative_models``    (9), (11) and the exact rates of (r, theta, z, chi, v), one file each
``drift``              how fast a drift is, how sharp it makes the turn
``drifting_orbit``     the periodic orbit under drift and its turn rate
``dryden``             how strong gusts are and how long they last
``relative``           the coordinates (r, theta, z, chi, v), steady inputs, tracking errors
``symbolic_work``      expressions are built by one thread at a time
``buffered_function``  CasADi functions on arrays of their own
``discretisation``     Euler (10), Runge-Kutta 4, error form (11), linearisation (12)
=====================  =====================================================================
"""
