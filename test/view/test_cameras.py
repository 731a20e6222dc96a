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

"""Cameras: what each view shows, and that it is the scene that moves."""

import math
import types
from dataclasses import replace

import numpy as np
import pytest
from watched_flight_stand_in import StandInFlight, sight

from uav_tracking_mpc.dynamics.orbit import FlownOrbit

cameras = pytest.importorskip("uav_tracking_mpc.view.cameras", exc_type=ImportError)
rigid = pytest.importorskip("viser.transforms")
from uav_tracking_mpc.view.scene.wind import LOW, WORDS  # noqa: E402

CENTRE = np.array([1000.0, -500.0, 120.0])
SIGHT = sight(
    wanted=FlownOrbit(CENTRE, np.zeros(3), 275.0, 22.0),
    position=np.add(CENTRE, [275.0, 0.0, 3.0]),
    heading=2.0,
    path_angle=0.1,
    bank=0.4,
)
FLIGHT = StandInFlight()


def picture(pose, points, aspect):
    """Right and up of points in a picture whose edges are at -1 and 1."""
    forward = pose.look_at - pose.position
    forward = forward / np.linalg.norm(forward)
    right = np.cross(forward, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    up = np.cross(right, forward)
    seen = points - pose.position
    depth = (seen @ forward) * math.tan(0.5 * cameras.FIELD_OF_VIEW)
    return np.column_stack([seen @ right / depth / aspect, seen @ up / depth])


def circle(centre):
    angle = np.linspace(0.0, 2.0 * math.pi, 50)
    return centre + 275.0 * np.column_stack([np.cos(angle), np.sin(angle), 0.0 * angle])


@pytest.mark.parametrize("aspect", [2.0, 1.0, 0.5])
@pytest.mark.parametrize("view", [cameras.ORBIT, cameras.FREE, cameras.ABOVE])
def test_the_whole_orbit_is_in_the_first_view(view, aspect):
    moved = cameras.scene_pose(view, SIGHT)
    orbit = np.array([moved @ point for point in circle(CENTRE)])
    seen = picture(cameras.first_pose(view, (FLIGHT, SIGHT), aspect), orbit, aspect)
    assert np.abs(seen).max() < 1.0
    assert np.abs(seen).max() > 0.5


@pytest.mark.parametrize("aspect", [2.0, 1.4, 1.0])
def test_the_first_view_of_an_orbit_is_the_same_a_little_beside_it_and_shows_the_wind(aspect):
    poses = [
        cameras.first_pose(
            cameras.ORBIT,
            (FLIGHT, replace(SIGHT, position=np.add(CENTRE, [275.0 + off, 0.0, 0.0]))),
            aspect,
        )
        for off in (-2.0, 2.0)
    ]
    np.testing.assert_array_equal(poses[0], poses[1])
    words = 275.0 * WORDS + [0.0, 0.0, LOW * CENTRE[2]]
    assert np.abs(picture(poses[0], words[None], aspect)).max() < 0.9


@pytest.mark.parametrize(
    ("width", "aspect", "unfolded"),
    [(1060, 1.4, True), (860, 1.4, True), (660, 1.4, False), (900, 0.5, False)],
)
def test_the_legend_is_unfolded_where_the_orbit_then_stands_beside_it(width, aspect, unfolded):
    assert bool(cameras.covered(width, aspect)) == unfolded


def test_a_scene_that_has_room_for_the_legend_leaves_it(page):
    """Its camera counts the pixels of the screen: a small page may have many."""
    page.camera.image_width, aside = 3000, []
    for width in (math.nan, 800.0, 1000.0):
        seat = cameras.Seat(page, "/world", [page.camera.position])
        seat.width = width
        seat.show(("aircraft",), {"aircraft": (FLIGHT, SIGHT)}, None)
        aside.append(page.camera.look_at[0])
    assert aside[0] == aside[1] > aside[2]


@pytest.mark.parametrize("view", [cameras.ORBIT, cameras.FREE, cameras.ABOVE])
def test_the_orbit_stands_beside_the_legend(view):
    moved, covered = cameras.scene_pose(view, SIGHT), 0.3
    orbit = np.array([moved @ point for point in circle(CENTRE)])
    seen = picture(cameras.first_pose(view, (FLIGHT, SIGHT), 1.34, covered), orbit, 1.34)
    assert seen[:, 0].min() > -1.0 + 2.0 * covered
    assert np.abs(seen).max() < 1.0


@pytest.mark.parametrize("view", [cameras.ORBIT, cameras.FREE, cameras.ABOVE])
def test_north_is_up_and_east_is_right(view):
    moved = cameras.scene_pose(view, SIGHT)
    points = np.array([moved @ (CENTRE + step) for step in ([0, 0, 0], [0, 50, 0], [50, 0, 0])])
    middle, north, east = picture(cameras.first_pose(view, (FLIGHT, SIGHT), 1.0), points, 1.0)
    assert north[1] > middle[1]
    assert north[0] == pytest.approx(middle[0], abs=1e-6)
    assert east[0] > middle[0]


def test_a_camera_that_follows_has_the_aircraft_in_its_middle():
    moved = cameras.scene_pose(cameras.FOLLOW, SIGHT)
    np.testing.assert_allclose(moved @ SIGHT.position, np.zeros(3), atol=1e-9)
    pose = cameras.first_pose(cameras.FOLLOW, (FLIGHT, SIGHT), 1.0)
    np.testing.assert_allclose(pose.look_at, np.zeros(3))
    ahead = np.array([math.cos(SIGHT.heading), math.sin(SIGHT.heading), 0.0])
    assert pose.position @ ahead < 0.0  # it begins behind the aircraft
    assert pose.position[2] > 0.0


def test_in_the_cockpit_the_nose_is_ahead_and_the_horizon_banks():
    moved = cameras.scene_pose(cameras.COCKPIT, SIGHT)
    turned = moved.rotation().as_matrix()
    chi, psi = SIGHT.path_angle, SIGHT.heading
    nose = [math.cos(chi) * math.cos(psi), math.cos(chi) * math.sin(psi), math.sin(chi)]
    np.testing.assert_allclose(turned @ nose, [1.0, 0.0, 0.0], atol=1e-9)
    # A bank to the right turns what is up in the world to the left, y of base_link.
    assert (turned @ [0.0, 0.0, 1.0])[1] > 0.3
    np.testing.assert_allclose(moved @ SIGHT.position, np.zeros(3), atol=1e-9)


def test_a_free_camera_sees_the_scene_where_it_is():
    moved = cameras.scene_pose(cameras.FREE, SIGHT)
    np.testing.assert_allclose(moved @ SIGHT.position, SIGHT.position)


def test_on_a_phone_the_orbit_is_seen_above_the_panel():
    """The panel takes the lower part of a page that is higher than wide."""
    for view in (cameras.ORBIT, cameras.FREE, cameras.ABOVE):
        moved = cameras.scene_pose(view, SIGHT)
        middle = np.array([moved @ CENTRE])
        seen = picture(cameras.first_pose(view, (FLIGHT, SIGHT), 0.5), middle, 0.5)
        np.testing.assert_allclose(seen, [[0.0, cameras.UP]], atol=0.1)


class StandInPage:
    """A page, as far as its seat knows it; keeps the frames that are added for it."""

    def __init__(self):
        self.frames = {}
        self.view = types.SimpleNamespace(value=cameras.ORBIT, on_update=lambda called: None)
        self.gui = types.SimpleNamespace(add_dropdown=lambda *_, **__: self.view)
        self.scene = types.SimpleNamespace(add_frame=self._add)
        self.camera = types.SimpleNamespace(aspect=1.2, position=np.zeros(3))

    def _add(self, name, **_):
        self.frames[name] = types.SimpleNamespace(name=name, visible=True)
        return self.frames[name]


@pytest.fixture
def page():
    return StandInPage()


def test_the_scene_of_a_new_page_turns_into_its_place(page, monkeypatch):
    now = [100.0]
    monkeypatch.setattr(cameras.time, "monotonic", lambda: now[0])
    seat, turns = cameras.Seat(page, "/world", []), []
    for elapsed in (0.0, 0.5 * cameras.OPENING, cameras.OPENING, 2.0 * cameras.OPENING):
        now[0] = 100.0 + elapsed
        seat.show(("aircraft",), {"aircraft": (FLIGHT, SIGHT)}, None)
        turns.append(rigid.SO3(np.array(page.frames["/world"].wxyz)).log()[2])
    assert turns[0] == pytest.approx(cameras.OPENING_TURN)
    assert turns[0] > turns[1] > turns[2] == turns[3] == 0.0


def test_nothing_of_the_own_aircraft_is_seen_from_the_cockpit(page):
    seat, own = cameras.Seat(page, "/world", []), "/world/aircraft/aircraft/own"
    for view, seen in ((cameras.COCKPIT, False), (cameras.FOLLOW, True), (cameras.COCKPIT, False)):
        page.view.value = view
        seat.show(("aircraft",), {"aircraft": (FLIGHT, SIGHT)}, None)
        assert page.frames[own].visible == seen


def test_the_first_view_follows_the_shape_of_the_picture_until_a_hand_moves_it(page):
    """A page tells its shape before its panel stands beside the scene, and again afterwards."""
    seat, camera = cameras.Seat(page, "/world", [np.zeros(3)]), page.camera
    seat.width, places = 1000.0, []
    for aspect, by_hand in ((1.6, False), (1.3, False), (1.3, False), (1.9, True)):
        camera.aspect = aspect
        camera.position = camera.position + 50.0 * by_hand
        seat.show(("aircraft",), {"aircraft": (FLIGHT, SIGHT)}, None)
        places.append(np.array(camera.position))
    assert np.abs(places[1] - places[0]).max() > 10.0
    np.testing.assert_array_equal(places[2], places[1])
    np.testing.assert_array_equal(places[3], places[1] + 50.0)


def test_the_first_view_is_framed_again_when_the_orbit_is_known(page):
    """A record may begin before its controller has told what it flies."""
    seat, places = cameras.Seat(page, "/world", [np.zeros(3)]), []
    for seen in (replace(SIGHT, wanted=None), SIGHT, SIGHT):
        seat.show(("aircraft",), {"aircraft": (FLIGHT, seen)}, None)
        places.append(np.array(page.camera.position))
    assert np.abs(places[1] - places[0]).max() > 10.0
    np.testing.assert_array_equal(places[2], places[1])
