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

import logging
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from solver_problems import PAPER_START, paper
from waiting import wait_for

from uav_tracking_mpc.mpc import compiled_method
from uav_tracking_mpc.mpc.newton_solver import NewtonSolver

PROGRAM = """
import logging, signal, sys
signal.signal(signal.SIGINT, signal.default_int_handler)  # a background job starts deaf to it
logging.basicConfig(level=logging.INFO, stream=sys.stdout, format="%(message)s")
import casadi as ca, numpy as np
from uav_tracking_mpc.mpc.problem import OptimalControlProblem
x, u = ca.SX.sym("x", 1), ca.SX.sym("u", 1)
problem = OptimalControlProblem(
    state=x, inputs=u, next_state=x + 0.1 * u, stage_cost=x**2 + u**2, terminal_cost=x**2,
    horizon=3, step=0.1, input_lower=np.array([-1.0]), input_upper=np.array([1.0]),
)
from uav_tracking_mpc.mpc.newton_solver import NewtonSolver
print("begin", flush=True)
print(NewtonSolver(problem).solve([0.5]).message)
print("numba" in sys.modules)
"""


def start(cache: Path, **environment: str) -> subprocess.Popen[str]:
    path = os.pathsep.join(filter(None, sys.path))
    return subprocess.Popen(
        [sys.executable, "-c", PROGRAM],
        env={**os.environ, "PYTHONPATH": path, "XDG_CACHE_HOME": str(cache), **environment},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def finish(process: subprocess.Popen[str]) -> str:
    output, errors = process.communicate(timeout=300)
    assert process.returncode == 0, errors
    return output


def compiler_of(process: subprocess.Popen[str]) -> int:
    """Process id of the child that compiles."""
    tasks = Path(f"/proc/{process.pid}/task")  # a thread of its own starts the child
    deadline = time.monotonic() + 60.0
    while time.monotonic() < deadline:
        if words := [
            word for task in tasks.glob("*/children") for word in task.read_text().split()
        ]:
            return int(words[0])
        time.sleep(0.01)
    raise AssertionError("nothing compiles")


def gone(process: int) -> bool:
    """Whether a process has ended; one that nobody has waited for yet counts."""
    try:
        return Path(f"/proc/{process}/stat").read_text().rsplit(")", 1)[1].split()[0] == "Z"
    except OSError:
        return True


def test_first_process_compiles_the_next_one_loads_without_the_compiler(tmp_path):
    first = finish(start(tmp_path))
    assert "converged" in first
    (made,) = (tmp_path / "uav_tracking_mpc").glob("newton_*/method.o")
    written = made.stat().st_mtime_ns
    second = finish(start(tmp_path))
    assert "compiling" not in second
    assert "converged" in second
    assert "False" in second
    assert made.stat().st_mtime_ns == written


def test_processes_that_start_together_compile_once(tmp_path):
    processes = [start(tmp_path) for _ in range(3)]
    outputs = [finish(process) for process in processes]
    assert all("converged" in output for output in outputs)
    (folder,) = (tmp_path / "uav_tracking_mpc").glob("newton_*")
    assert [path.name for path in folder.glob("*.[0-9]*")] == []
    assert len((folder / "lock").read_text().split()) == 1  # process ids of those that compiled


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux tells children of the death")
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGKILL])
def test_a_signal_ends_the_wait_at_once_and_the_next_process_compiles(tmp_path, number):
    process = start(tmp_path)
    assert process.stdout is not None
    assert process.stdout.readline() == "begin\n"
    child = compiler_of(process)
    process.send_signal(number)
    process.communicate(timeout=60)
    assert process.returncode != 0
    assert wait_for(lambda: gone(child)), "the compiler outlives the process that wants it"
    assert not list((tmp_path / "uav_tracking_mpc").glob("newton_*/method.json"))
    assert "converged" in finish(start(tmp_path))


@pytest.mark.skipif(sys.platform != "linux", reason="reads /proc")
def test_a_waiter_that_is_killed_leaves_the_others_waiting(tmp_path):
    first = start(tmp_path)
    compiler_of(first)
    second = start(tmp_path)
    compiler_of(second)
    first.kill()
    first.communicate(timeout=60)
    assert "converged" in finish(second)


def test_sources_of_the_package_are_only_read(monkeypatch, tmp_path):
    folder = Path(compiled_method.__file__).parent / "newton"
    before = {path: path.stat().st_mtime_ns for path in folder.glob("*.py")}
    NewtonSolver(paper())
    assert {path: path.stat().st_mtime_ns for path in folder.glob("*.py")} == before
    assert not list(folder.glob("__pycache__/*.nbi"))


def test_two_solvers_of_one_problem_do_not_share_state():
    one, other = NewtonSolver(paper()), NewtonSolver(paper())
    plan = one.solve(PAPER_START)
    other.solve(0.5 * PAPER_START)
    warm = one.solve(plan.states[1], elapsed=1.0)
    assert warm.converged
    assert warm.iterations < 15


def test_what_is_compiled_is_only_loaded(caplog):
    NewtonSolver(paper())
    with caplog.at_level(logging.INFO):
        NewtonSolver(paper())
    assert not caplog.records  # a compilation is announced
