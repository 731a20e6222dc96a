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

"""The orbit survives its way through diagnostics to the last digit."""

import math

import pytest

from uav_tracking_mpc.dynamics.orbit import COUNTER_CLOCKWISE, Orbit
from uav_tracking_mpc.nodes.reported_orbit import orbit_changes, orbit_values, reported_orbit

FIRST = Orbit(300.0 + math.pi, 120.0, 22.0 / 7.0, COUNTER_CLOCKWISE)
SECOND = Orbit(350.0, 100.0, 20.0)


def test_there_and_back():
    values = {key: str(value) for key, value in orbit_values(FIRST).items()}
    assert reported_orbit(values) == FIRST


@pytest.mark.parametrize("values", [{}, {"orbit range [m]": "nan"}, {"direction": "up"}])
def test_what_holds_no_orbit(values):
    assert reported_orbit(values) is None


def test_only_changes_count_and_only_those_of_the_flight():
    reports = [(5, SECOND), (1_000_000_000, FIRST), (2_000_000_000, FIRST), (3_000_000_000, SECOND)]
    assert orbit_changes(reports, 500_000_000) == ((0.5, FIRST), (2.5, SECOND))
    assert orbit_changes([], 0) == ()
