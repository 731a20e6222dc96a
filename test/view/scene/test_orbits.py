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

"""Orbits and the plan: where they are."""

import numpy as np
import viser.transforms
from watched_flight_stand_in import StandInFlight, sight

from uav_tracking_mpc.control.fallback import FallbackMode
from uav_tracking_mpc.dynamics.orbit import FlownOrbit
from uav_tracking_mpc.report.mode_colours import mode_colour
from uav_tracking_mpc.view.scene.orbits import Orbits, Plan


def orbit(radius):
    return FlownOrbit(np.array([10.0, 20.0, 120.0]), np.zeros(3), radius, 22.0)


def test_both_are_moved_and_scaled(draw, node):
    draw(Orbits, StandInFlight()).show(sight(wanted=orbit(275.0), flown=orbit(-300.0)))
    for name, radius in (("wanted", 275.0), ("flown", 300.0)):
        circle = node(f"orbits/{name}")
        np.testing.assert_allclose(circle.position, [10.0, 20.0, 120.0])
        away = np.linalg.norm((circle.points * circle.scale)[:40], axis=-1)
        np.testing.assert_allclose(away, radius, rtol=1e-5)


def test_the_arrow_heads_of_a_clockwise_orbit_turn_the_other_way(draw, node):
    draw(Orbits, StandInFlight()).show(sight(wanted=orbit(275.0), flown=orbit(-275.0)))
    for name, sense in (("wanted", 1.0), ("flown", -1.0)):
        circle = node(f"orbits/{name}")
        behind, tip = viser.transforms.SO3(circle.wxyz).apply(circle.points[-1].astype(float))
        assert sense * np.cross(behind, tip)[2] > 0.0
        assert np.all(np.asarray(circle.scale) > 0.0)  # of what is mirrored nothing is seen


def test_an_orbit_that_is_not_known_is_hidden(draw, node):
    element = draw(Orbits, StandInFlight())
    element.show(sight(wanted=orbit(275.0)))
    assert node("orbits/wanted").visible
    assert not node("orbits/flown").visible
    element.show(sight())
    assert not node("orbits/wanted").visible


PLAN = np.array([[275.0, 0.0, 121.0], [274.0, 9.0, 121.0], [272.0, 18.0, 120.5]])


def test_ghosts_fly_the_plan(draw, node):
    draw(Plan, StandInFlight()).show(
        sight(plan=PLAN, mode=FallbackMode.EARLIER_PLAN, ground_velocity=np.array([0.0, 22.0, 0.0]))
    )
    ghosts = node("plan/ghosts")
    np.testing.assert_allclose(ghosts.batched_positions, PLAN[1:], rtol=1e-6)
    np.testing.assert_allclose(
        node("plan/line").points, np.stack([PLAN[:-1], PLAN[1:]], axis=1), rtol=1e-6
    )
    assert tuple(ghosts.batched_colors) == mode_colour(FallbackMode.EARLIER_PLAN)
    turned = viser.transforms.SO3(ghosts.batched_wxyzs[-1].astype(float))
    along = (PLAN[2] - PLAN[1]) / np.linalg.norm(PLAN[2] - PLAN[1])
    np.testing.assert_allclose(turned.apply(np.array([1.0, 0.0, 0.0])), along, atol=1e-6)
    left_wing = turned.apply(np.array([0.0, 1.0, 0.0]))
    assert left_wing[2] < -0.1  # it turns to the left


def test_a_planned_orbit_that_is_the_wanted_one_is_not_drawn_twice(draw, node):
    element = draw(Orbits, StandInFlight())
    for radius, seen in ((276.0, False), (300.0, True), (-275.0, True)):
        element.show(sight(wanted=orbit(275.0), flown=orbit(radius)))
        assert node("orbits/flown").visible == seen


def test_without_a_plan_nothing_is_left_standing(draw, node):
    element = draw(Plan, StandInFlight())
    for missing in (None, np.full((3, 3), np.nan), PLAN[:1]):
        element.show(sight(plan=PLAN))
        assert node("plan/line").visible
        element.show(sight(plan=missing))
        assert not node("plan/line").visible
        assert not node("plan/ghosts").visible
