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

"""The plan: its stages stand where the sight says."""

import numpy as np
from watched_flight_stand_in import StandInFlight, sight

from uav_tracking_mpc.control.fallback import FallbackMode
from uav_tracking_mpc.report.mode_colours import mode_colour
from uav_tracking_mpc.view.scene.plan import Plan

PLAN = np.array([[275.0, 0.0, 121.0], [274.0, 9.0, 121.0], [272.0, 18.0, 120.5]])


def test_stages_stand_where_the_sight_says(draw, node):
    draw(Plan, StandInFlight()).show(sight(plan=PLAN, mode=FallbackMode.EARLIER_PLAN))
    np.testing.assert_allclose(node("plan/stages").points, PLAN, rtol=1e-6)
    np.testing.assert_allclose(
        node("plan/line").points, np.stack([PLAN[:-1], PLAN[1:]], axis=1), rtol=1e-6
    )
    assert tuple(node("plan/stages").colors) == mode_colour(FallbackMode.EARLIER_PLAN)


def test_without_a_plan_nothing_is_left_standing(draw, node):
    element = draw(Plan, StandInFlight())
    for missing in (None, np.full((3, 3), np.nan), PLAN[:1]):
        element.show(sight(plan=PLAN))
        assert node("plan/line").visible
        element.show(sight(plan=missing))
        assert not node("plan/line").visible
        assert not node("plan/stages").visible
