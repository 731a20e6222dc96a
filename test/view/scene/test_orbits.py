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

"""Orbits: where they are, how large, and which way round."""

import numpy as np
import viser.transforms
from watched_flight_stand_in import StandInFlight, sight

from uav_tracking_mpc.dynamics.flown_orbit import FlownOrbit
from uav_tracking_mpc.view.scene.orbits import Orbits


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
