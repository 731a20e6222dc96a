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

import asyncio
import math
import types
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
import viser.transforms as rigid
from watched_flight_stand_in import StandInClient, StandInFlight, StandInSteering, sight

from uav_tracking_mpc.view.scene.orbits import TargetTrack
from uav_tracking_mpc.view.scene.target import Forecast, Target, TargetDrag, caption, meets_height
from uav_tracking_mpc.view.watched_flight import CONTROLLER, TargetSight

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


CAMERA = np.array([0.0, -500.0, 400.0])


class ClientOfScene(StandInClient):
    """A page, for which the scene may be moved."""

    def __init__(self, moved=None):
        super().__init__()
        self.camera = types.SimpleNamespace(position=CAMERA)
        self.moved = moved
        world = None
        if moved is not None:
            world = types.SimpleNamespace(wxyz=moved.rotation().wxyz, position=moved.translation())
            self.camera.position = moved @ CAMERA
        self.scene = types.SimpleNamespace(get_handle_by_name=lambda name: world)

    def tells(self, point):
        return np.array(point) if self.moved is None else self.moved @ np.array(point)


def event(client, phase, begin, end):
    return types.SimpleNamespace(
        client=client,
        phase=phase,
        start_position=client.tells(begin),
        end_position=client.tells(end),
    )


@pytest.fixture
def flight():
    return StandInFlight(steering=StandInSteering())


@pytest.fixture
def drag(draw, flight):
    """Drag from a point to a point in ``map``; returns what the element did with it."""
    draw(Target, flight).show(sight(target=TargetSight(PLACE)))
    element = draw(TargetDrag, flight)
    element.show(sight(target=TargetSight(PLACE)))

    def gesture(client, *ends, release=True):
        async def play():
            for end in ends:
                await element._dragged(event(client, "update", PLACE, end))
            if release:
                await element._dragged(event(client, "end", PLACE, ends[-1]))
                await asyncio.get_running_loop().shutdown_default_executor()

        with ThreadPoolExecutor(1) as pool:  # a browser's tests leave a loop running in this one
            pool.submit(asyncio.run, play()).result()

    return gesture


def half_way(point):
    """A point on the ray from the camera to a point: what the page tells of the pointer."""
    return 0.5 * (CAMERA + point)


def test_a_ray_meets_the_ground():
    np.testing.assert_allclose(
        meets_height([0.0, 0.0, 100.0], [1.0, 2.0, 99.0], 10.0), [90.0, 180.0, 10.0]
    )
    assert meets_height([0.0, 0.0, 100.0], [1.0, 2.0, 101.0], 10.0) is None
    assert meets_height([0.0, 0.0, 100.0], [1.0, 2.0, 100.0], 10.0) is None
    assert meets_height([0.0, 0.0, math.nan], [1.0, 2.0, 99.0], 10.0) is None


FOLLOWED = rigid.SE3.from_translation(np.array([-275.0, 20.0, -120.0]))
COCKPIT = rigid.SE3.from_rotation_and_translation(
    rigid.SO3.from_rpy_radians(0.3, 0.1, 1.0), np.array([50.0, -20.0, 7.0])
)


@pytest.mark.parametrize("moved", [None, FOLLOWED, COCKPIT])
def test_it_is_sent_to_where_it_is_let_go(drag, flight, moved):
    wanted = np.array([130.0, 60.0, 2.0])
    drag(ClientOfScene(moved), half_way(np.array([50.0, 0.0, 2.0])), half_way(wanted))
    [(request, east, north)] = flight.steering.asked
    assert request == "send_target"
    np.testing.assert_allclose([east, north], wanted[:2], atol=1e-6)


def test_a_ghost_shows_where_it_would_stand(drag, node):
    drag(ClientOfScene(), half_way(np.array([130.0, 60.0, 2.0])), release=False)
    assert node("target_ghost").visible
    np.testing.assert_allclose(node("target_ghost").position, [130.0, 60.0, 2.0])
    assert node("target_ghost/label").text == "to 130 m east, 60 m north"
    drag(ClientOfScene(), half_way(np.array([130.0, 60.0, 2.0])))
    assert not node("target_ghost").visible


def test_let_go_in_the_sky_it_stays(drag, flight):
    drag(ClientOfScene(), np.add(CAMERA, [0.0, 100.0, 50.0]))
    assert flight.steering.asked == []


def test_a_refusal_is_shown_to_the_page_that_asked(drag, flight):
    flight.steering.refusal = "parameter 'position' is beyond the fence"
    client = ClientOfScene()
    drag(client, half_way(np.add(PLACE, [10.0, 0.0, 0.0])))
    assert [body for _, body in client.notifications] == [flight.steering.refusal]


@pytest.mark.parametrize("steering", [None, StandInSteering([CONTROLLER])])
def test_without_a_target_publisher_it_cannot_be_dragged(draw, scene, sent, steering):
    flight = StandInFlight(steering=steering)
    draw(Target, flight)
    draw(TargetDrag, flight).show(sight())
    assert not any("DragBindings" in type(message).__name__ for message in sent)


def test_a_hint_says_so_until_the_target_was_sent(draw, node, drag, flight):
    assert node("target_handle").visible
    assert node("target_hint").visible
    drag(ClientOfScene(), half_way(np.array([130.0, 60.0, 2.0])))
    later = draw(TargetDrag, StandInFlight())
    later.show(sight(target=TargetSight(PLACE)))
    assert not node("target_handle").visible  # nobody steers this one
