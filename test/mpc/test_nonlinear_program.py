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

from __future__ import annotations

import numpy as np
from solver_problems import PAPER_START, paper

from uav_tracking_mpc.mpc.newton_solver import NewtonSolver
from uav_tracking_mpc.mpc.nonlinear_program import NonlinearProgram


def test_a_plan_survives_packing_and_rolling_out():
    problem = paper()
    program, plan = NonlinearProgram(problem), NewtonSolver(problem).solve(PAPER_START)
    p = np.tile(problem.usual_parameter, (problem.horizon + 1, 1))
    states = program.rollout(plan.states[0], plan.inputs, p, plan.decision)
    np.testing.assert_allclose(states, plan.states, rtol=1e-9, atol=1e-9)
    unpacked = program.unpack(program.pack(plan.states, plan.inputs, plan.decision))
    for found, packed in zip(unpacked, (plan.states, plan.inputs, plan.decision), strict=True):
        np.testing.assert_array_equal(found, packed)


def test_where_the_model_has_no_value_the_guess_stands_still():
    problem = paper()
    inputs = np.full((problem.horizon, problem.nu), np.nan)
    p = np.tile(problem.usual_parameter, (problem.horizon + 1, 1))
    states = NonlinearProgram(problem).rollout(PAPER_START, inputs, p, np.zeros(0))
    np.testing.assert_array_equal(states, np.tile(PAPER_START, (problem.horizon + 1, 1)))
