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

"""The numbers of the paper: Table 1, the weights (59), and the initial state of Section 6.

``config/paper.yaml`` says the same to those who fly it; a test compares the two.
"""

from __future__ import annotations

import math

from uav_tracking_mpc.dynamics.orbit import Orbit

ORBIT = Orbit(range=150.0, altitude=50.0, speed=4.0)
STEP = 1.0  # s, T_s of Table 1
HORIZON = 10  # N of Table 1
STATE_WEIGHTS = (0.008, 0.09, 0.05, 0.04, 0.9)  # diagonal of Q, (59)
INPUT_WEIGHTS = (1.0, 1.0, 1.0)  # diagonal of R, (59)
SCALING = 2.5  # -, rho of (28)
# U is never printed. With these bounds the terminal level (60) comes out within 1 %.
TURN_RATE_BOUND = math.pi / 4.0  # rad/s, of u_psi, from (60)
PATH_ANGLE_RATE_BOUND = math.pi / 4.0  # rad/s, of u_chi, from (60)
ACCELERATION_BOUND = 1.0  # m/s^2, of u_v, from (60)
INPUT_BOUNDS = (TURN_RATE_BOUND, PATH_ANGLE_RATE_BOUND, ACCELERATION_BOUND)
# m, rad, m, rad, m/s: x_o of Section 6, the state (r, theta, z, chi, v) itself, not its error.
INITIAL_STATE = (212.83, -math.pi / 4.0, 20.0, 0.0, 0.0)
DURATION = 150.0  # s, of the simulation in Section 6
