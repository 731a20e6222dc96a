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

"""A loiter law flown without a simulator: the exact vehicle, 20 Hz, perfect knowledge."""

import numpy as np
import small_uav

from uav_tracking_mpc.dynamics.vehicle import advance
from uav_tracking_mpc.estimation.situation import Situation

STEP = 0.05
SMALL_UAV = small_uav.parameters().envelope


def fly(law, start, duration, wind=(0.0, 0.0, 0.0), target_velocity=(0.0, 0.0, 0.0)):
    """Offsets from the target (n, 3), vehicle states (n, 6) and inputs (n, 3)."""
    vehicle, target = np.array(start, dtype=float), np.zeros(3)
    wind, run, rates = np.array(wind), np.array(target_velocity), np.zeros(3)
    offsets, vehicles, inputs = [], [], []
    for _ in range(round(duration / STEP)):
        situation = Situation(vehicle, target, wind - run, np.zeros(3), rates)
        rates = law.inputs(situation)
        offsets.append(situation.offset)
        vehicles.append(vehicle)
        inputs.append(rates)
        vehicle = advance(vehicle, rates, STEP)
        vehicle[:3] += STEP * wind
        target = target + STEP * run
    return np.array(offsets), np.array(vehicles), np.array(inputs)


def range_errors(law, offsets):
    return np.linalg.norm(offsets, axis=1) - law.orbit.range
