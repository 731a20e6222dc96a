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

"""Velocity through the air, over ground and the drift close a triangle."""

import numpy as np
from watched_flight_stand_in import StandInFlight, sight

from uav_tracking_mpc.view.scene.velocities import Velocities, arrows


def test_the_drift_leads_from_the_one_to_the_other():
    seen = sight(
        heading=0.0, path_angle=0.0, airspeed=20.0, ground_velocity=np.array([20.0, 5.0, 0.0])
    )
    ground, air, drift = arrows(seen)
    np.testing.assert_allclose(ground, [[0.0, 0.0, 0.0], [1.0, 0.25, 0.0]])
    np.testing.assert_allclose(air, [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]])
    np.testing.assert_allclose(drift, [air[1], ground[1]])


def test_in_still_air_there_is_one():
    seen = sight(
        heading=0.0, path_angle=0.0, airspeed=20.0, ground_velocity=np.array([20.0, 0.0, 0.0])
    )
    assert len(arrows(seen)) == 1


def test_they_are_hidden_where_the_airspeed_is_not_known(draw, node):
    element = draw(Velocities, StandInFlight())
    element.show(sight())
    assert node("aircraft/velocities").visible
    element.show(sight(airspeed=np.nan))
    assert not node("aircraft/velocities").visible
