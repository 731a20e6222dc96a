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

"""Ghosts of laws that are flown beside."""

import numpy as np
from watched_flight_stand_in import StandInFlight, sight

from uav_tracking_mpc.view.scene.rivals import Rivals
from uav_tracking_mpc.view.watched_flight import RivalSight

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
    element.show(sight())
    assert not node("rivals/l1/body").visible
    assert not node("rivals/l1/label").visible
