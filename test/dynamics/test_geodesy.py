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

"""Latitude and longitude to East, North, Up against properties of the ellipsoid."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from uav_tracking_mpc.dynamics.geodesy import FLATTENING, SEMI_MAJOR_AXIS, LocalFrame

LATITUDES = st.floats(-1.55, 1.55)
LONGITUDES = st.floats(-math.pi, math.pi)


@given(LATITUDES, LONGITUDES, st.floats(-1e4, 1e4), st.floats(-1e4, 1e4), st.floats(-500, 5e3))
def test_a_position_and_its_place_are_one(latitude, longitude, east, north, up):
    frame = LocalFrame(latitude, longitude, 100.0)
    position = [east, north, up]
    np.testing.assert_allclose(frame.position(*frame.place(position)), position, atol=1e-6)


@given(LATITUDES, LONGITUDES, st.floats(0.0, 3e3))
def test_the_axes_point_east_north_and_up(latitude, longitude, altitude):
    frame, small = LocalFrame(latitude, longitude, altitude), 1e-6
    start = np.zeros(3)
    np.testing.assert_allclose(frame.position(latitude, longitude, altitude), start, atol=1e-6)
    np.testing.assert_allclose(
        frame.position(latitude, longitude, altitude + 7.0), [0, 0, 7], atol=1e-6
    )
    east, north = (
        frame.position(latitude, longitude + small, altitude),
        frame.position(latitude + small, longitude, altitude),
    )
    assert east[0] > 0.0
    assert abs(east[1]) < 1e-3 * east[0] + 1e-5
    assert north[1] > 0.0
    assert abs(north[0]) < 1e-3 * north[1]


def test_a_degree_has_the_length_of_the_ellipsoids_radii():
    latitude, step = math.radians(47.0), math.radians(1e-4)
    squared = FLATTENING * (2.0 - FLATTENING)
    root = math.sqrt(1.0 - squared * math.sin(latitude) ** 2)
    across, along = SEMI_MAJOR_AXIS / root, SEMI_MAJOR_AXIS * (1.0 - squared) / root**3
    frame = LocalFrame(latitude, 0.1, 0.0)
    assert frame.position(latitude + step, 0.1, 0.0)[1] == pytest.approx(along * step, rel=1e-6)
    east = frame.position(latitude, 0.1 + step, 0.0)[0]
    assert east == pytest.approx(across * math.cos(latitude) * step, rel=1e-6)


@pytest.mark.parametrize("place", [(2.0, 0.0, 0.0), (math.nan, 0.0, 0.0), (0.0, math.inf, 0.0)])
def test_what_is_no_place_is_refused(place):
    with pytest.raises(ValueError, match="must be finite and within 90 deg of the equator"):
        LocalFrame(*place)
