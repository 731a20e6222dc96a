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

import dataclasses

import numpy as np
import pytest
from solver_problems import PAPER_START, paper, paper_solver, pendulum

from uav_tracking_mpc.mpc.cold_start import openings
from uav_tracking_mpc.mpc.newton_solver import NewtonSolver


def test_openings_are_rest_feedback_single_inputs_and_corners():
    problem = paper()
    tried = openings(problem, np.zeros(3), 3)
    assert len(tried) == 2 + 6 + 8
    assert tried[0].shape == (problem.horizon, 3)
    assert len(tried[1]) == 0
    for inputs in tried:
        assert np.all(inputs >= problem.input_lower)
        assert np.all(inputs <= problem.input_upper)


@pytest.mark.filterwarnings("error")
def test_inputs_without_bounds_open_at_rest():
    free = dataclasses.replace(
        pendulum(), input_lower=np.array([-np.inf]), input_upper=np.array([np.inf])
    )
    assert all(np.all(inputs == 0.0) for inputs in openings(free, np.zeros(1), 3))
    assert NewtonSolver(free).solve(np.array([-0.3, 0.0])).converged


def test_cold_start_does_not_depend_on_what_was_solved_before():
    solver = paper_solver()
    solver.reset()
    first = solver.solve(PAPER_START)
    solver.solve(-0.3 * PAPER_START)
    again = solver.solve(PAPER_START)
    np.testing.assert_array_equal(first.inputs, again.inputs)
    assert first.iterations == again.iterations
