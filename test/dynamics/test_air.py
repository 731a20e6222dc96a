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

"""The standard atmosphere against its published table."""

import math

import pytest

from uav_tracking_mpc.dynamics.air import density_ratio, true_over_equivalent

SEA_LEVEL_DENSITY = 1.225  # kg/m^3
# U.S. Standard Atmosphere 1976, Table I: altitude in m, density in kg/m^3
TABLE = [(-1000.0, 1.3470), (0.0, 1.2250), (1000.0, 1.1117), (3000.0, 0.90925), (11000.0, 0.36480)]


@pytest.mark.parametrize(("altitude", "density"), TABLE)
def test_the_density_is_that_of_the_table(altitude, density):
    # The table is by geometric altitude: the formula's is lower by altitude / radius of the earth.
    geopotential = altitude / (1.0 + altitude / 6356766.0)
    assert SEA_LEVEL_DENSITY * density_ratio(geopotential) == pytest.approx(density, rel=2e-4)


def test_the_true_airspeed_is_the_greater_the_thinner_the_air():
    assert true_over_equivalent(0.0) == pytest.approx(1.0)
    assert true_over_equivalent(2000.0) == pytest.approx(1.0 / math.sqrt(density_ratio(2000.0)))
    assert true_over_equivalent(2000.0) > true_over_equivalent(1000.0) > 1.0


def test_beyond_the_troposphere_its_edge_counts():
    assert density_ratio(5e4) == density_ratio(11000.0)
    assert density_ratio(-1e5) == density_ratio(-5000.0)
