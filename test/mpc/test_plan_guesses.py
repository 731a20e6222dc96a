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

"""Plans to begin from: the last one moved on, that of the caller, or two cold ones."""

import dataclasses

import numpy as np
from solver_problems import paper_solver

from uav_tracking_mpc.mpc.plan_guesses import plan_guesses
from uav_tracking_mpc.mpc.solution import Solution, Status
from uav_tracking_mpc.mpc.solver import Guess

PROBLEM = paper_solver().problem
STATE = np.full(PROBLEM.nx, 0.5)


def rolled(inputs, decision):
    return np.vstack([STATE, np.tile(inputs.sum(axis=1), (PROBLEM.nx, 1)).T])


def last():
    plan = Solution.without_plan(PROBLEM, Status.FAILED, "", 0.0)
    stages = np.arange(PROBLEM.horizon, dtype=float)[:, np.newaxis]
    return dataclasses.replace(plan, inputs=stages * np.ones(PROBLEM.nu))


def test_a_warm_start_moves_the_last_plan_on_and_begins_at_the_state():
    (guess,) = plan_guesses(PROBLEM, STATE, last(), PROBLEM.step, None, rolled)
    np.testing.assert_array_equal(guess.states[0], STATE)
    np.testing.assert_allclose(guess.inputs[:3, 0], [1.0, 2.0, 3.0])
    assert guess.inputs[-1, 0] == PROBLEM.horizon - 1


def test_a_cold_start_takes_the_plan_of_the_caller_or_two_of_its_own():
    told = Guess(np.full((PROBLEM.horizon, PROBLEM.nu), 0.1), np.zeros(PROBLEM.na))
    (guess,) = plan_guesses(PROBLEM, STATE, last(), None, lambda: told, rolled)
    np.testing.assert_array_equal(guess.inputs, told.inputs)
    np.testing.assert_array_equal(guess.states, rolled(told.inputs, told.decision))
    for make in (None, lambda: None):
        goal, still = plan_guesses(PROBLEM, STATE, None, PROBLEM.step, make, rolled)
        np.testing.assert_array_equal(goal.states[1:], 0.0)
        np.testing.assert_array_equal(still.states, np.tile(STATE, (PROBLEM.horizon + 1, 1)))
        np.testing.assert_array_equal(goal.states[0], STATE)
