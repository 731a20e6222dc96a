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

"""The grid under a flight, and the sky over it."""

import numpy as np
import pytest
from watched_flight_stand_in import StandInFlight, sight

from uav_tracking_mpc.dynamics.orbit import FlownOrbit
from uav_tracking_mpc.view.cameras import FAR
from uav_tracking_mpc.view.scene.airframe import DropLine
from uav_tracking_mpc.view.scene.ground import Ground, cell_size, distance, sky
from uav_tracking_mpc.view.watched_flight import TargetSight


def about(east, north, radius=275.0):
    centre = np.array([east, north, 120.0])
    return sight(wanted=FlownOrbit(centre, np.zeros(3), radius, 22.0))


@pytest.mark.parametrize(("radius", "cell"), [(141.0, 50.0), (275.0, 100.0), (3000.0, 1000.0)])
def test_cells_fit_the_flight(radius, cell):
    assert cell_size(radius) == pytest.approx(cell)


def test_distances_are_read_with_their_direction():
    assert [distance(value, "EW") for value in (0.0, 200.0, -400.0, 12_500.0)] == [
        "0",
        "200 m E",
        "400 m W",
        "12.5 km E",
    ]


def labels(scene, axis):
    names = [f"/world/ground-grid/{axis}_{k}" for k in range(-2, 3)]
    return [scene.get_handle_by_name(name) for name in names]


def test_labels_stand_at_what_they_say_and_follow_the_flight(draw, scene):
    element = draw(Ground, StandInFlight())
    element.show(about(0.0, 0.0))
    assert [label.text for label in labels(scene, "x")][3:] == ["200 m E", "400 m E"]
    element.show(about(2010.0, 30.0))
    east = labels(scene, "x")
    assert [label.text for label in east][2:] == ["2000 m E", "2200 m E", "2400 m E"]
    np.testing.assert_allclose([label.position[0] for label in east], np.arange(1600, 2401, 200))


def test_it_stays_while_the_flight_stays(draw, sent):
    element = draw(Ground, StandInFlight())
    element.show(about(0.0, 0.0))
    sent.clear()
    element.show(about(60.0, -40.0))
    assert sent == []


def test_it_lies_at_the_height_of_the_target(draw, node, scene):
    flight = StandInFlight()
    seen = sight(target=TargetSight(np.array([0.0, 0.0, 40.0])))
    draw(Ground, flight).show(seen)
    assert scene.get_handle_by_name("/world/ground-grid").position[2] == 40.0
    draw(DropLine, flight).show(seen)
    assert node("aircraft/own/drop_line").scale[2] == pytest.approx(121.0 - 40.0)


def test_a_second_aircraft_draws_none(draw, sent):
    draw(Ground, StandInFlight("aircraft")).show(about(0.0, 0.0))
    other = draw(Ground, StandInFlight("other"))
    sent.clear()
    other.show(about(5000.0, 0.0))
    assert sent == []


def test_the_sky_meets_the_ground_within_what_a_camera_sees(draw, scene):
    draw(Ground, StandInFlight()).show(about(2010.0, 30.0))
    dome = sky()
    points = dome.vertices + scene.get_handle_by_name("/world/ground-grid/sky").position
    away = np.linalg.norm(points - [2010.0, 30.0, 0.0], axis=1)
    assert away.max() < 0.7 * FAR
    np.testing.assert_allclose(points[:, 2].min(), 0.0, atol=1e-6)
    assert points[:, 2].max() > 0.5 * away.max()
