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

"""The aircraft stands where it is, and banks and pitches as flown."""

import dataclasses
import math

import numpy as np
import viser.transforms as rigid
from watched_flight_stand_in import StandInFlight, sight

from uav_tracking_mpc.control.fallback import FallbackMode
from uav_tracking_mpc.report.mode_colours import mode_colour
from uav_tracking_mpc.view.scene.airframe import Airframe, Rivals, caption
from uav_tracking_mpc.view.watched_flight import RivalSight


def drawn(draw, node, **more):
    """Points of fuselage and wings in ``map``, from the aircraft, as shares of its length."""
    flight = StandInFlight()
    draw(Airframe, flight).show(sight(**more))
    turned = rigid.SO3(np.array(node("aircraft/own/body").wxyz))
    return tuple(
        turned @ node(f"aircraft/own/body/{part}").vertices.astype(float)
        for part in ("fuselage", "wings")
    )


def test_it_stands_where_the_aircraft_is(draw, node):
    drawn(draw, node)
    np.testing.assert_allclose(node("aircraft").position, [275.0, 0.0, 121.0])
    assert node("aircraft").visible


def test_a_bank_to_the_right_lowers_the_right_wing(draw, node):
    _, wings = drawn(draw, node, heading=math.pi / 2.0, path_angle=0.0, bank=0.5)
    right, left = wings[np.argmax(wings[:, 0])], wings[np.argmin(wings[:, 0])]  # it flies north
    assert right[2] < -0.2
    assert left[2] > 0.2


def test_a_climb_raises_the_nose(draw, node):
    fuselage, _ = drawn(draw, node, heading=0.0, path_angle=0.3, bank=0.0)
    nose = fuselage[np.argmax(fuselage[:, 0])]
    np.testing.assert_allclose(nose, 0.5 * np.array([math.cos(0.3), 0.0, math.sin(0.3)]), atol=1e-6)


def test_a_bank_that_is_not_known_is_drawn_level(draw, node):
    _, wings = drawn(draw, node, heading=0.0, path_angle=0.0, bank=math.nan)
    assert np.ptp(wings[:, 2]) < 0.2


def test_wings_and_words_tell_what_is_flown(draw, node):
    drawn(draw, node, mode=FallbackMode.LOITER)
    assert node("aircraft/own/body/wings").color == mode_colour(FallbackMode.LOITER)
    assert node("aircraft/own/label").text == "aircraft: loiter law"
    assert caption("aircraft", FallbackMode.OPTIMAL) == "aircraft"
    assert caption("aircraft", None) == "aircraft: no command yet"


PLACE = np.array([100.0, 50.0, 120.0])


def test_they_stand_where_they_fly_with_their_errors(draw, node):
    rivals = tuple(
        RivalSight(law, PLACE, 0.0, 0.0, 0.0, error) for law, error in (("l1", 3.14), ("npfg", -2))
    )
    element = draw(Rivals, StandInFlight())
    element.show(sight(rivals=rivals))
    np.testing.assert_allclose(node("rivals/l1/body").position, PLACE)
    texts = [node(f"rivals/{law}/label").text for law in ("l1", "npfg")]
    assert texts == ["l1: +3.1 m", "npfg: -2.0 m"]
    low, high = (node(f"rivals/{law}/label").position[2] for law in ("l1", "npfg"))
    assert high > low  # one's words over the other's
    lost = dataclasses.replace(rivals[0], position=np.full(3, math.nan))
    for gone in ((), (lost,)):
        element.show(sight(rivals=rivals))
        element.show(sight(rivals=gone))
        assert not node("rivals/l1/body").visible
        assert not node("rivals/l1/label").visible
