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

"""Limits stand where they are, and glow as they are neared."""

import numpy as np
import pytest
from watched_flight_stand_in import StandInFlight, sight

from uav_tracking_mpc.settings.configuration import load_configuration
from uav_tracking_mpc.view.scene import GREY, LIMIT
from uav_tracking_mpc.view.scene.limits import FAINT_OPACITY, GLOW, GLOWING_OPACITY, Limits, glow
from uav_tracking_mpc.view.watched_flight import TargetSight

FENCED = ("fence_radius=800.0", "fence_centre=[100.0,-50.0]")


@pytest.fixture
def limit(scene):
    """The node of a limit, or None."""

    def find(name):
        for k in range(9):
            handle = scene.get_handle_by_name(f"/world/aircraft/limits/{name}_{k}")
            if handle is not None:
                return handle
        return None

    return find


class FlightWithin(StandInFlight):
    """Flies by parameters that a test chooses."""

    def __init__(self, *overrides):
        super().__init__()
        self.within(*overrides)

    def within(self, *overrides):
        settings = [f"nmpc_controller.{override}" for override in overrides]
        self._tracking = load_configuration("small_uav", settings).controller

    @property
    def tracking(self):
        return self._tracking


def test_fence_floor_and_least_distance(draw, scene, limit):
    element = draw(Limits, FlightWithin(*FENCED))
    element.show(sight(target=TargetSight(np.array([5.0, 6.0, 7.0]))))
    np.testing.assert_allclose(limit("fence").position, [100.0, -50.0, 7.0])
    wall = scene.get_handle_by_name(f"{limit('fence').name}/wall")
    np.testing.assert_allclose(wall.scale[:2], 800.0)
    np.testing.assert_allclose(limit("height").position[2], 30.0)
    np.testing.assert_allclose(limit("distance").position, [5.0, 6.0, 7.0])
    assert scene.get_handle_by_name(f"{limit('distance').name}/lines").scale == 60.0


def test_a_limit_that_is_taken_away_goes(draw, limit):
    flight = FlightWithin(*FENCED)
    element = draw(Limits, flight)
    element.show(sight())
    assert limit("fence") is not None
    flight.within("height_min=-1e5")
    element.show(sight())
    assert limit("fence") is None
    assert limit("height") is None
    assert limit("distance") is not None


@pytest.mark.parametrize("target", [None, TargetSight(np.full(3, np.nan))])
def test_the_least_distance_is_hidden_while_there_is_no_target(draw, limit, target):
    draw(Limits, FlightWithin()).show(sight(target=target))
    assert not limit("distance").visible


def at(east, up=121.0):
    return sight(position=np.array([east, 0.0, up]))


def test_the_fence_glows_as_it_is_neared(draw, scene, limit):
    element = draw(Limits, FlightWithin("fence_radius=800.0", "fence_centre=[0.0,0.0]"))
    opacities = []
    for east in (0.0, 750.0, 799.9):
        element.show(at(east))
        wall = scene.get_handle_by_name(f"{limit('fence').name}/wall")
        opacities.append(wall.opacity)
    assert opacities[0] == FAINT_OPACITY < opacities[1] < opacities[2] == GLOWING_OPACITY


def test_the_floor_is_seen_where_it_is_near(draw, scene, limit):
    element = draw(Limits, FlightWithin())
    element.show(at(275.0))
    assert not limit("height").visible
    element.show(at(275.0, 31.0))
    assert limit("height").visible


def test_the_sphere_about_the_target_turns_from_grey_to_the_colour_of_limits(draw, scene, limit):
    element = draw(Limits, FlightWithin())
    for east, colour in ((275.0, GREY), (60.0, LIMIT)):
        element.show(at(east, 0.0))
        skin, rim = (
            scene.get_handle_by_name(f"{limit('distance').name}/{part}")
            for part in ("skin", "lines")
        )
        assert skin.color == tuple(rim.colors) == colour


def test_a_glow_is_told_in_steps():
    glows = {glow(away, 100.0) for away in np.linspace(-10.0, 100.0, 500)}
    assert {0.0, 1.0} < glows
    assert len(glows) < 20
    assert glow(GLOW * 100.0, 100.0) == 0.0
    assert glow(np.nan, 100.0) == 0.0
