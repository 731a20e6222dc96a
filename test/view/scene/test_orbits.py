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

import dataclasses
import itertools

import numpy as np
import pytest
import viser.transforms
from watched_flight_stand_in import StandInFlight, sight

from uav_tracking_mpc.control.fallback import FallbackMode
from uav_tracking_mpc.dynamics.orbit import FlownOrbit
from uav_tracking_mpc.report.mode_colours import mode_colour
from uav_tracking_mpc.view.scene.orbits import (
    SCALE,
    SPAN,
    Orbits,
    Plan,
    Track,
    dashes,
    linear,
    speed_colour,
)


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


def along_east(times):
    return [sight(time, position=np.array([20.0 * time, 5.0, 100.0])) for time in times]


def fly(element, flight, sights):
    for seen in sights:
        flight.seen.append(seen)
        element.show(seen)


@pytest.fixture
def flown(draw):
    """Ten seconds at 20 Hz."""
    flight = StandInFlight()
    flight.seen = along_east([0.0])
    element = draw(Track, flight)
    fly(element, flight, along_east(np.arange(0.0, 10.0, 0.05)))
    return element, flight


def test_old_parts_are_drawn_as_shorter_dashes():
    times = np.arange(0.0, SPAN, 0.5)
    points = np.column_stack([times, np.zeros_like(times), np.zeros_like(times)])
    segments = dashes(times, points)
    lengths = np.linalg.norm(segments[:, 1] - segments[:, 0], axis=1)
    assert np.all(np.diff(lengths) > -1e-12)
    assert lengths[0] < 0.2 * lengths[-1]
    np.testing.assert_allclose(segments[-1], points[-2:])


def test_it_goes_on_to_where_the_aircraft_is(flown, node):
    _, flight = flown
    line, head = node("track/line").points, node("track/head").points
    np.testing.assert_allclose(head[-1, 1], flight.seen[-1].position, rtol=1e-6)
    np.testing.assert_allclose(head[0, 0], line[-1, 1], atol=1.0)
    for earlier, later in itertools.pairwise(head):
        np.testing.assert_allclose(earlier[1], later[0])


def test_no_more_than_a_minute_is_kept(flown, node):
    element, flight = flown
    fly(element, flight, along_east(np.arange(10.0, 100.0, 0.25)))
    line = node("track/line").points
    assert 35.0 < line[0, 1, 0] / 20.0 < 40.5
    assert len(line) <= 300


def test_the_whole_line_is_sent_only_now_and_then(flown, sent):
    element, flight = flown
    fly(element, flight, along_east(np.arange(10.0, 20.0, 0.05)))
    lines = [m for m in sent if m.name.endswith("track/line") and "points" in m.updates]
    assert 0 < len(lines) <= 10


def test_after_a_jump_of_time_the_past_is_asked_for(flown, node):
    element, flight = flown
    flight.seen = along_east(np.arange(200.0, 230.0, 0.2))
    element.show(flight.seen[-1])
    np.testing.assert_allclose(node("track/line").points[-1, 1, 0], 20.0 * 229.8, rtol=1e-5)
    flight.seen = along_east(np.arange(0.0, 5.0, 0.2))
    element.show(flight.seen[-1])
    np.testing.assert_allclose(node("track/line").points[:, 1, 0].max(), 20.0 * 4.8, rtol=1e-5)


def test_no_line_leads_to_where_a_reset_puts_the_aircraft(flown, node):
    element, flight = flown
    there = [
        dataclasses.replace(each, position=np.add(each.position, [900.0, 0.0, 0.0]))
        for each in along_east(np.arange(10.0, 13.0, 0.05))
    ]
    for seen in there:
        fly(element, flight, [seen])
        for part in ("line", "head"):
            segments = node(f"track/{part}").points
            assert np.abs(segments[:, 1] - segments[:, 0]).max() < 20.0


def test_an_aircraft_that_stands_has_none(draw, node):
    flight = StandInFlight()
    element = draw(Track, flight)
    for time in np.arange(10.0, 15.0, 0.1):
        element.show(dataclasses.replace(flight.seen[0], time=time))
    assert not node("track/line").visible
    assert not node("track/head").visible


def test_the_colour_tells_how_the_air_carries_the_aircraft(flown, node):
    seen = [sight(ground_velocity=np.array([speed, 0.0, 0.0])) for speed in (5.0, 22.5, 50.0)]
    for one, colour in zip(seen, SCALE, strict=True):
        np.testing.assert_array_equal(speed_colour(one), linear(colour))
    np.testing.assert_array_equal(
        speed_colour(sight(airspeed=np.nan, ground_velocity=np.ones(3))), linear(SCALE[1])
    )
    line = node("track/line")
    assert line.colors.shape == line.points.shape
