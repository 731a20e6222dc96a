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
import pytest
from filled_messages import over_the_wire

from uav_tracking_mpc.dynamics.orbit import Orbit
from uav_tracking_mpc.nodes.controller.controller_views import markers_message, path_message


def test_what_viewers_get_can_be_serialized():
    states = np.column_stack([np.arange(5.0)] * 6)
    path = over_the_wire(path_message(1, states))
    assert [pose.pose.position.x for pose in path.poses] == [0.0, 1.0, 2.0, 3.0, 4.0]
    markers = over_the_wire(markers_message(1, states, np.zeros(3), Orbit(150.0, 50.0, 4.0)))
    circle = markers.markers[1].points
    assert np.hypot(circle[9].x, circle[9].y) == pytest.approx(np.sqrt(20000.0))
    assert len({marker.id for marker in markers.markers}) == 4
