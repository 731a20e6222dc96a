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

"""The wind in words and as streaks, and the triangle of velocities."""

import numpy as np
import pytest
import viser.transforms as rigid
from watched_flight_stand_in import StandInFlight, sight

from uav_tracking_mpc.view.scene.wind import Velocities, Wind, arrows, streaks, words


@pytest.mark.parametrize(
    ("wind", "text"),
    [
        ((8.0, 0.0, 0.0), "wind 8.0 m/s from W"),
        ((0.0, -3.0, 0.5), "wind 3.0 m/s from N"),
        ((-1.0, -1.0, 0.0), "wind 1.4 m/s from NE"),
        ((-2.0, 0.0, 0.0), "wind 2.0 m/s from E"),
    ],
)
def test_it_is_named_by_where_it_comes_from(wind, text):
    assert words(np.array(wind)) == text


def test_the_streaks_point_where_it_blows_and_drift_with_it(draw, node):
    element = draw(Wind, StandInFlight())
    places = []
    for time in (10.0, 10.5):
        element.show(sight(time, wind=np.array([0.0, -6.0, 0.0])))
        field = node("wind/field")
        begin, tip = rigid.SO3(np.array(field.wxyz)).apply(field.points[0].astype(float))
        assert (tip - begin)[1] < -0.1
        places.append(np.array(field.position))
    np.testing.assert_allclose(places[1] - places[0], [0.0, -3.0, 0.0], atol=1e-6)


def test_a_stronger_wind_has_longer_streaks():
    lengths = [np.ptp(streaks(speed)[0, :, 0]) for speed in (2.0, 8.0, 14.0, 40.0)]
    assert np.all(np.diff(lengths) > 0.0)
    assert lengths[-1] < 1.0


def test_calm_or_unknown_air_shows_none(draw, node):
    element = draw(Wind, StandInFlight())
    for calm in (None, np.zeros(3), np.full(3, np.nan)):
        element.show(sight(wind=np.array([0.0, -6.0, 0.0])))
        assert node("wind").visible
        element.show(sight(wind=calm))
        assert not node("wind").visible


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
    assert np.ptp(arrows(seen)[:, :, 0], axis=1).round(2).tolist() == [1.0, 0.0, 0.0]


def test_they_are_hidden_where_the_airspeed_is_not_known(draw, node):
    element = draw(Velocities, StandInFlight())
    element.show(sight())
    assert node("aircraft/own/velocities").visible
    element.show(sight(airspeed=np.nan))
    assert not node("aircraft/own/velocities").visible
