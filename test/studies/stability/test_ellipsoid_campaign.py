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

"""Short form of the campaign: flights from X_f show what was proved."""

from uav_tracking_mpc.studies.stability.ellipsoid_campaign import fly_local, fly_nmpc, random_states
from uav_tracking_mpc.terminal.stability_problem import paper_problem

PROBLEM, LEVEL = paper_problem(), 2.87


def test_local_controller():
    result = fly_local(PROBLEM, LEVEL, random_states(PROBLEM, LEVEL, 2000))
    assert result.clean
    assert result.flights == 2000


def test_nmpc():
    states = random_states(PROBLEM, LEVEL, 40, seed=5)
    assert fly_nmpc(PROBLEM, LEVEL, states, workers=1, show=False).clean


def test_campaign_sees_a_level_that_is_too_large():
    states = random_states(PROBLEM, 40.0, 2000)
    result = fly_local(PROBLEM, 40.0, states, steps=3)
    assert result.outside_inputs > 0
    assert not result.clean
