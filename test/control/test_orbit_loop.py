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

"""The controller's own gain near the orbit, and the margins it has."""

import math

import numpy as np
import pytest
import small_uav

from uav_tracking_mpc.control.orbit_loop import OrbitLoop
from uav_tracking_mpc.dynamics.response import Response
from uav_tracking_mpc.settings.configuration import load_configuration

STILL = np.zeros(3)


@pytest.fixture(scope="module")
def loop():
    return OrbitLoop(small_uav.parameters())


def test_the_gain_turns_inward_from_outside(loop):
    """Clockwise: a wider orbit asks for more of the negative turn rate."""
    gain = loop.gain(loop.orbit_in(STILL))
    turn, climb, acceleration = gain
    assert turn[0] < 0.0 and climb[1] < 0.0 and acceleration[4] < 0.0
    assert abs(turn[0]) > 2.0 * abs(turn[1])


def test_the_gain_is_a_derivative(loop):
    """Half the differences give the same: neither limits nor the solver's tolerance show."""
    where = loop.orbit_in(STILL)
    whole = loop.gain(where)
    deviation = np.array([0.05, -0.02, 5e-4, 2e-4, 0.01, -5e-4, 1e-4, 0.01])
    above, below = (loop._answer(where.situation(s * deviation), 0.0) for s in (1.0, -1.0))
    np.testing.assert_allclose(above - below, 2.0 * whole @ deviation, rtol=2e-3, atol=1e-6)


def test_small_uav_has_the_margins_that_are_asked(loop):
    found = loop.margins(loop.orbit_in(STILL))
    for channel in found.channels.values():
        assert channel.delay_s >= 0.3
        assert channel.gain_db >= 6.0
    drift = np.array([-5.0, 8.0, 0.0])
    for azimuth in (0.0, 2.0, 4.0):
        in_wind = loop.margins(loop.orbit_in(drift, azimuth))
        assert min(channel.delay_s for channel in in_wind.channels.values()) >= 0.3


def test_in_still_air_the_azimuth_does_not_matter(loop):
    first, second = (loop.margins(loop.orbit_in(STILL, azimuth)) for azimuth in (0.2, 3.0))
    assert first.disk == pytest.approx(second.disk, rel=1e-3)


def test_other_weights_other_margins(loop):
    quick = small_uav.parameters("input_weights=[0.04, 0.04, 0.2]", "rate_weights=[0.0, 0.0, 0.0]")
    calm = loop.margins(loop.orbit_in(STILL))
    loop.change(quick)
    hasty = loop.margins(loop.orbit_in(STILL))
    loop.change(small_uav.parameters())
    assert hasty.channels["turn"].delay_s < 0.3 < calm.channels["turn"].delay_s
    assert loop.margins(loop.orbit_in(STILL)).disk == pytest.approx(calm.disk, rel=1e-3)


def test_an_aircraft_later_than_its_margin_is_unstable(loop):
    channel = loop.margins(loop.orbit_in(STILL)).channels["path"]
    late = loop.told.dead_times + np.array([0.0, 1.05 * channel.delay_s, 0.0])
    found = loop.margins(loop.orbit_in(STILL), Response(loop.told.lags, late, np.ones(3)))
    assert found.disk == 0.0


@pytest.mark.parametrize("law", ["l1", "vector_field"])
def test_laws_have_margins_too(law):
    parameters = load_configuration("small_uav", [f"nmpc_controller.law={law}"]).controller
    found = OrbitLoop(parameters)
    margins = found.margins(found.orbit_in(STILL))
    assert 0.0 < margins.disk < 2.0
    assert all(math.isfinite(channel.gain_db) for channel in margins.channels.values())


def test_so_has_the_papers_controller():
    found = OrbitLoop(load_configuration("paper").controller)
    assert found.margins(found.orbit_in(STILL)).channels["turn"].delay_s > 1.0
