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

"""A law of which the turn rate alone is flown."""

import numpy as np
import pytest
import small_uav

from uav_tracking_mpc.control.guidance import law_about, law_inputs
from uav_tracking_mpc.laws import GuidanceLaw
from uav_tracking_mpc.laws.vector_field import VectorField

FREE = small_uav.parameters()
HELD = small_uav.parameters("autopilot_holds=true")
LOW = small_uav.situation(z=90.0, airspeed=20.0)


def test_the_turn_is_the_laws_and_the_rest_the_autopilots():
    free, held = (law_about(VectorField, p.orbit, p) for p in (FREE, HELD))
    assert isinstance(free, VectorField)
    assert held.name == free.name
    turn, climb, gain = held.inputs(LOW)
    assert turn == free.inputs(LOW)[0]
    model = HELD.vehicle
    state = model.initial(LOW.vehicle, LOW.target, LOW.rates)
    expected = model.held(state, 120.0, 22.0, model.numbers(0.4), LOW.drift)
    assert [climb, gain] == pytest.approx(expected)


class Broken(GuidanceLaw):
    name = "broken"

    def inputs(self, situation):
        return np.array([np.nan, 0.0, 0.0])


def test_a_law_that_fails_is_told_by_its_name():
    inputs, words = law_inputs(law_about(Broken, HELD.orbit, HELD), LOW)
    assert inputs is None
    assert "the law broken answered [nan" in words
