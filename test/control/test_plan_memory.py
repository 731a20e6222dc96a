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
import pytest

from uav_tracking_mpc.control.plan_memory import PlanMemory
from uav_tracking_mpc.formulation.formulation import Plan
from uav_tracking_mpc.mpc.solution import Solution, Status

NOTHING = np.zeros((0, 3))
SOLUTION = Solution(Status.CONVERGED, "", 1.0, 1, 0.0, NOTHING, NOTHING, np.zeros(3), 0.0)
PLAN = Plan(np.arange(9.0).reshape(3, 3), 0.5, np.zeros(5), SOLUTION)


@pytest.fixture
def memory():
    memory = PlanMemory()
    memory.keep(PLAN, 10.0)
    return memory


@pytest.mark.parametrize(("time", "first"), [(10.0, 0), (10.49, 0), (10.5, 1), (11.49, 2)])
def test_the_segments_that_have_been_flown_are_left_out(memory, time, first):
    inputs, step = memory.remaining(time, 5.0)
    np.testing.assert_array_equal(inputs, PLAN.inputs[first:])
    assert step == PLAN.step


@pytest.mark.parametrize(("time", "age_max"), [(9.9, 5.0), (11.5, 5.0), (10.6, 0.5)])
def test_a_plan_of_the_future_or_flown_or_too_old_is_none(memory, time, age_max):
    assert memory.remaining(time, age_max) is None


def test_what_is_forgotten_is_gone(memory):
    memory.reset()
    assert memory.remaining(10.0, 5.0) is None
