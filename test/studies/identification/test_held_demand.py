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

"""The response against the simulator's inner loop, which is exact."""

import numpy as np
import pytest
from excited_channel import answer, excitation

from uav_tracking_mpc.studies.identification.channel_record import Samples
from uav_tracking_mpc.studies.identification.held_demand import HeldDemand


@pytest.mark.parametrize("lag", [0.0, 0.05, 0.3, 2.0])
@pytest.mark.parametrize("dead_time", [0.0, 0.13, 0.2])
def test_rate_and_integral_are_those_of_the_inner_loop(lag, dead_time):
    time, demand = excitation(seed=3, duration=20.0)
    demand[0] = 0.0  # the inner loop begins at rest
    rates, integrals = answer(demand, lag, dead_time)
    held = HeldDemand(Samples(time, demand))
    rate, integral = held.response(time, lag, dead_time, held.rates_at_steps(lag))
    later = time > dead_time + 1e-9  # a command that comes on at this very time counts already
    if lag:
        np.testing.assert_allclose(rate[later], rates[later], atol=1e-10)
    shift = integral[-1] - integrals[-1]
    np.testing.assert_allclose(integral[later], integrals[later] + shift, atol=1e-9)


def test_between_the_steps_the_rate_decays_exponentially():
    held = HeldDemand(Samples(np.array([0.0, 1.0]), np.array([0.0, 2.0])))
    time = np.array([1.3, 1.75])
    rate, _ = held.response(time, 0.5, 0.1, held.rates_at_steps(0.5))
    np.testing.assert_allclose(rate, 2.0 * (1.0 - np.exp(-(time - 1.1) / 0.5)))
