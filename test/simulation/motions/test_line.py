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
from uav_tracking_mpc.simulation.motions.line import Line


def test_it_runs_straight_towards_its_heading():
    line = Line(TargetParameters(position=(1.0, 2.0, 3.0), speed=5.0, heading=np.pi / 2))
    np.testing.assert_allclose(line.position(4.0), [1.0, 22.0, 3.0])
    np.testing.assert_allclose(line.velocity(4.0), [0.0, 5.0, 0.0], atol=1e-12)
