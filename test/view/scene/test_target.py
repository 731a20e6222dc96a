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

"""The target: where it is drawn, and where it is expected."""

import math

import numpy as np
import pytest
from watched_flight_stand_in import StandInFlight, sight

from uav_tracking_mpc.view.scene.target import Forecast, Target, caption
from uav_tracking_mpc.view.scene.tracks import TargetTrack
from uav_tracking_mpc.view.watched_flight import TargetSight

PLACE = np.array([30.0, -40.0, 2.0])


def test_it_stands_on_its_place_with_its_uncertainty(draw, node):
    seen = TargetSight(PLACE, std=2.0, measured=PLACE + 1.0, truth=PLACE + 4.0)
    draw(Target, StandInFlight()).show(sight(target=seen))
    np.testing.assert_allclose(node("target").position, PLACE)
    assert node("target/pin").vertices[:, 2].min() == 0.0
    assert node("target/three_sigma").scale == 6.0
    np.testing.assert_allclose(node("target_measured").position, PLACE + 1.0)
    np.testing.assert_allclose(node("target_truth").position, PLACE + 4.0)


def test_what_is_not_known_is_hidden(draw, node):
    element = draw(Target, StandInFlight())
    element.show(sight(target=TargetSight(PLACE, std=2.0, measured=PLACE, truth=PLACE)))
    assert not node("target_truth").visible  # it is where it is taken to be
    element.show(sight(target=TargetSight(PLACE)))
    assert node("target").visible
    assert not node("target/three_sigma").visible
    assert not node("target_measured").visible
    for missing in (None, TargetSight(np.array([math.nan, 0.0, 0.0]), measured=PLACE)):
        element.show(sight(target=missing))
        assert not node("target").visible
        assert not node("target_measured").visible


def test_its_speed_is_told_in_half_metres_a_second():
    assert caption(TargetSight(PLACE)) == "target"
    assert caption(TargetSight(PLACE, np.array([0.1, 0.1, 0.0]))) == "target"
    assert caption(TargetSight(PLACE, np.array([3.0, 4.1, 0.0]))) == "target 5.0 m/s"


def test_its_track_goes_to_where_it_is(draw, node):
    flight = StandInFlight()
    element = draw(TargetTrack, flight)
    for time in np.arange(10.0, 20.0, 0.05):
        flight.seen.append(sight(time, target=TargetSight(np.array([time, 0.0, 0.0]))))
        element.show(flight.seen[-1])
    np.testing.assert_allclose(node("target_track/head").points[-1, 1, 0], 19.95, rtol=1e-6)


AHEAD = np.array([[0.0, 0.0, 0.0, 1.0], [25.0, 0.0, 0.0, 2.0], [50.0, 0.0, 0.0, 4.0]])


def test_a_forecast_widens_along_the_way(draw, node):
    draw(Forecast, StandInFlight()).show(sight(target=TargetSight(PLACE, forecast=AHEAD)))
    assert node("forecast").visible
    points = node("forecast").points
    for place, std in ((25.0, 2.0), (50.0, 4.0)):
        away = np.linalg.norm(points - [place, 0.0, 0.0], axis=-1).ravel()
        assert np.isclose(away, 3.0 * std, rtol=1e-5).sum() >= 96


@pytest.mark.parametrize(
    "forecast", [None, np.full((3, 4), math.nan), AHEAD * [0.0, 0.0, 0.0, 1.0]]
)
def test_a_forecast_that_is_not_known_or_does_not_move_is_hidden(draw, node, forecast):
    draw(Forecast, StandInFlight()).show(sight(target=TargetSight(PLACE, forecast=forecast)))
    assert not node("forecast").visible
