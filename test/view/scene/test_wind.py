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

"""The wind: its words, and that calm air shows none."""

import numpy as np
import pytest
import viser.transforms as rigid
from watched_flight_stand_in import StandInFlight, sight

from uav_tracking_mpc.view.scene.wind import Wind, words


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


def test_the_arrow_points_where_it_blows(draw, node):
    draw(Wind, StandInFlight()).show(sight(wind=np.array([0.0, -6.0, 0.0])))
    arrow = node("wind/arrow")
    begin, tip = (
        rigid.SO3(np.array(arrow.wxyz)) @ point for point in arrow.points[0].astype(float)
    )
    np.testing.assert_allclose(tip - begin, [0.0, -1.0, 0.0], atol=1e-6)


def test_calm_or_unknown_air_shows_none(draw, node):
    element = draw(Wind, StandInFlight())
    for calm in (None, np.zeros(3), np.full(3, np.nan)):
        element.show(sight(wind=np.array([0.0, -6.0, 0.0])))
        assert node("wind").visible
        element.show(sight(wind=calm))
        assert not node("wind").visible
