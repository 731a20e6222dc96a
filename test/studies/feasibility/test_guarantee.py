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

"""What the page on guarantees claims of the steady orbit, checked on the problem itself."""

import numpy as np
import pytest

from uav_tracking_mpc.dynamics.vehicle_models import Drift, VehicleState
from uav_tracking_mpc.dynamics.vehicle_models.lagged import Lagged
from uav_tracking_mpc.studies.feasibility.guarantee import GUARANTEED, NOT_GUARANTEED, as_words

RADIUS, SPEED, STEP, LAG = 275.0, 22.0, 0.5, (0.3, 0.13, 0.16)


def test_steady_inputs_stay_on_the_orbit_without_drift():
    turn = SPEED / RADIUS
    state = VehicleState(RADIUS, 0.0, 120.0, np.pi / 2, 0.0, SPEED, turn, 0.0, 0.0)
    model, still = Lagged(LAG), Drift(np.zeros(3), np.zeros(3))
    for _ in range(200):
        state = model.step(state, [turn, 0.0, 0.0], STEP, model.numbers(STEP), still)
    assert np.hypot(state.x, state.y) == pytest.approx(RADIUS, abs=1e-4)
    assert state.turn_rate == pytest.approx(turn)


def test_the_words_hold_every_sentence():
    text = as_words()
    for words in (*GUARANTEED, *NOT_GUARANTEED):
        assert words in text
