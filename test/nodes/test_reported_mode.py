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

"""The fallback mode as the diagnostics of a bag tell it."""

import pytest

from uav_tracking_mpc.control.fallback import FallbackMode
from uav_tracking_mpc.nodes.reported_mode import MODE, REASON, mode_changes, reported_mode

OPTIMAL, LOITER = FallbackMode.OPTIMAL, FallbackMode.LOITER
SECOND = 1_000_000_000  # ns


@pytest.mark.parametrize("mode", FallbackMode)
def test_every_mode_comes_back(mode):
    assert reported_mode({MODE: mode.value, REASON: "why"}) == (mode, "why")


@pytest.mark.parametrize("values", [{}, {MODE: "upside down"}, {"reason": "why"}])
def test_a_report_without_a_mode(values):
    assert reported_mode(values) is None


def test_only_changes_count_and_only_those_of_the_flight():
    reports = [
        (0, FallbackMode.SILENCE, "no target position"),
        (2 * SECOND, OPTIMAL, ""),
        (3 * SECOND, OPTIMAL, ""),
        (4 * SECOND, LOITER, "target position is lost"),
        (5 * SECOND, LOITER, "target position is lost"),
        (6 * SECOND, OPTIMAL, ""),
        (9 * SECOND, FallbackMode.SILENCE, "shut down"),
    ]
    assert mode_changes(reports, SECOND, 8 * SECOND) == (
        (0.0, OPTIMAL, ""),
        (3.0, LOITER, "target position is lost"),
        (5.0, OPTIMAL, ""),
    )
    assert mode_changes([], 0, SECOND) == ()
