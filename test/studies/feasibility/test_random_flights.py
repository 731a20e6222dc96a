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

import numpy as np

from uav_tracking_mpc.dynamics.gravity import GRAVITY
from uav_tracking_mpc.settings.configuration import load_configuration
from uav_tracking_mpc.studies.feasibility.random_flights import random_situations

PARAMETERS = load_configuration("small_uav").controller


def test_states_are_inside_the_envelope_and_everywhere():
    situations = random_situations(PARAMETERS, 2000)
    vehicles = np.array([each.vehicle for each in situations])
    ranges = np.linalg.norm(vehicles[:, :3], axis=1)
    assert ranges.min() >= PARAMETERS.distance_min - 1e-9
    assert ranges.max() > 900.0
    assert vehicles[:, 2].min() >= PARAMETERS.height_min - 1e-9
    assert 14.0 <= vehicles[:, 5].min() <= vehicles[:, 5].max() <= 32.0
    turns = np.array([each.rates[0] for each in situations])
    assert np.all(np.abs(turns * vehicles[:, 5] / GRAVITY) <= np.tan(PARAMETERS.bank_max) + 1e-9)
    drifts = np.array([np.linalg.norm(each.drift) for each in situations])
    assert np.all(drifts <= 0.4 * np.minimum(vehicles[:, 5], 22.0) + 1e-9)
    assert 0.25 < np.mean(drifts == 0.0) < 0.35
    assert drifts.max() > 8.0


def test_states_are_those_of_the_seed():
    first, again, other = (random_situations(PARAMETERS, 3, seed) for seed in (1, 1, 2))
    np.testing.assert_array_equal(first[2].vehicle, again[2].vehicle)
    assert not np.array_equal(first[2].vehicle, other[2].vehicle)
