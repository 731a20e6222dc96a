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

import numpy as np

from uav_tracking_mpc.settings.target import TargetParameters
from uav_tracking_mpc.simulation.motions.stationary import Stationary


def test_it_stands_whatever_its_speed():
    target = Stationary(TargetParameters(position=(1.0, 2.0, 3.0), speed=5.0))
    np.testing.assert_array_equal(target.position(9.0), [1.0, 2.0, 3.0])
    np.testing.assert_array_equal(target.velocity(9.0), np.zeros(3))
