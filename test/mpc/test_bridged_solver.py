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

import math

import numpy as np
import pytest
from solver_problems import PAPER_START, paper

from uav_tracking_mpc.mpc import compiled_method, machine_code
from uav_tracking_mpc.mpc.bridged_solver import BUDGET, BridgedSolver
from uav_tracking_mpc.mpc.compiled_method import CompilationError, MachineCode
from uav_tracking_mpc.mpc.newton_solver import NewtonSolver
from uav_tracking_mpc.mpc.solver import Status


@pytest.fixture
def ready():
    """Whether the compiled solver is there; the test says so."""
    return []


@pytest.fixture
def solver(ready):
    return BridgedSolver(paper(), lambda: bool(ready))  # no time limit: the machine may be busy


def test_ipopt_solves_until_the_machine_code_is_there(solver, ready):
    first = solver.solve(PAPER_START)
    assert solver.name == "ipopt"
    assert first.converged
    warm = solver.solve(first.states[1], elapsed=solver.problem.step)
    assert warm.converged
    assert solver.solve(np.full(5, np.nan), elapsed=0.0).status is Status.REFUSED
    ready.append(True)
    assert solver.name == "ipopt"  # it changes with a solve, not between
    following = solver.solve(warm.states[1], elapsed=solver.problem.step)
    assert solver.name == "newton"
    assert following.converged
    assert following.iterations <= 10  # from the plan of the other
    alone = NewtonSolver(solver.problem).solve(warm.states[1])
    assert following.cost == pytest.approx(alone.cost, rel=1e-3)
    again = solver.solve(following.states[1], elapsed=solver.problem.step)
    assert again.converged


def test_what_is_compiled_solves_from_the_beginning(solver, ready):
    ready.append(True)
    assert solver.name == "newton"
    own, other = solver.solve(PAPER_START), NewtonSolver(solver.problem).solve(PAPER_START)
    np.testing.assert_array_equal(own.inputs, other.inputs)


def test_the_budget_is_that_of_the_solver_that_solves(solver, ready):
    assert solver.prepare().time_limit == math.inf
    solver.time_limit = 0.01
    assert solver.prepare().time_limit == BUDGET
    ready.append(True)
    solver.solve(PAPER_START)
    assert solver.prepare().time_limit == solver.time_limit == 0.01
    solver.time_limit = 0.03
    assert solver.prepare().time_limit == 0.03


def test_bad_data_is_refused_and_a_reset_starts_cold(solver, ready):
    assert solver.solve(np.full(5, np.nan)).status is Status.REFUSED
    solver.solve(PAPER_START)
    solver.reset()
    ready.append(True)
    own = solver.solve(PAPER_START, elapsed=0.1)
    other = NewtonSolver(solver.problem).solve(PAPER_START)
    np.testing.assert_array_equal(own.inputs, other.inputs)


class Told:
    """A compilation that ends as it is told."""

    seconds = 3.21

    def __init__(self, folder, **_):
        self.folder, self.answers = folder, [False, True]

    def done(self):
        answer = self.answers.pop(0)
        if isinstance(answer, Exception):
            raise answer
        return answer


@pytest.fixture
def compiled(monkeypatch, tmp_path):
    """Makes machine code that is there when the test says so; what it has reported."""
    monkeypatch.setattr(compiled_method, "Compilation", Told)
    monkeypatch.setattr(compiled_method, "method_folder", lambda problem: tmp_path)
    monkeypatch.setattr(compiled_method, "load", lambda folder: None)
    said = []
    return lambda: MachineCode(paper(), said.append), said


def test_begin_and_end_of_the_compilation_are_told_once(compiled, tmp_path):
    make, said = compiled
    code = make()
    assert [code(), code(), code()] == [False, True, True]
    assert said == [
        f"ipopt solves while the solver is compiled, once; kept in {tmp_path}",
        "solver compiled in 3.2 s; it solves from now on",
    ]


def test_where_it_cannot_be_compiled_ipopt_goes_on(compiled):
    make, said = compiled
    code = make()
    code._compilation.answers = [CompilationError("no memory")]
    assert [code(), code()] == [False, False]
    assert said[1:] == ["no memory; ipopt solves"]


@pytest.mark.parametrize("kept", [True, False])
def test_where_it_cannot_be_loaded_ipopt_solves(compiled, tmp_path, monkeypatch, kept):
    def refuse(folder):
        raise RuntimeError("no such relocation")

    make, said = compiled
    if kept:
        (tmp_path / machine_code.DESCRIPTION).write_text("{}")
    monkeypatch.setattr(compiled_method, "load", refuse)
    code = make()
    code._compilation.answers = [True]
    solver = BridgedSolver(paper(), code)
    assert solver.solve(PAPER_START).converged
    assert solver.name == "ipopt" and not solver.compiling
    words = "the solver cannot be loaded: RuntimeError: no such relocation; ipopt solves"
    assert said[-1] == words and len(said) == 2 - kept


def test_what_is_kept_is_not_compiled_again(compiled, tmp_path):
    make, said = compiled
    (tmp_path / machine_code.DESCRIPTION).write_text("{}")
    code = make()
    code._compilation.answers = [True]
    assert code() and not said
