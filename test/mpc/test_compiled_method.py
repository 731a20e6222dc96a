from __future__ import annotations

import logging
import os
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from solver_problems import PAPER_START, paper

from uav_tracking_mpc.mpc import compiled_method as compilation
from uav_tracking_mpc.mpc.newton_solver import NewtonSolver

PROGRAM = """
import logging, sys, time
logging.basicConfig(level=logging.INFO, stream=sys.stdout, format="%(message)s")
import casadi as ca, numpy as np
from uav_tracking_mpc.mpc.problem import OptimalControlProblem
x, u = ca.SX.sym("x", 1), ca.SX.sym("u", 1)
problem = OptimalControlProblem(
    state=x, inputs=u, next_state=x + 0.1 * u, stage_cost=x**2 + u**2, terminal_cost=x**2,
    horizon=3, step=0.1, input_lower=np.array([-1.0]), input_upper=np.array([1.0]),
)
from uav_tracking_mpc.mpc.newton_solver import NewtonSolver
print(NewtonSolver(problem).solve([0.5]).message)
"""


def run(environment: dict[str, str]) -> str:
    result = subprocess.run(
        [sys.executable, "-c", PROGRAM],
        env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path), **environment},
        capture_output=True,
        text=True,
        timeout=110,
        check=False,
    )
    assert result.returncode == 0, result.stderr
    return result.stdout


def test_first_process_compiles_and_says_so_the_next_one_loads(tmp_path):
    environment = {"XDG_CACHE_HOME": str(tmp_path)}
    first = run(environment)
    assert "compiling the solver" in first
    assert "converged" in first
    assert list((tmp_path / "uav_tracking_mpc").glob("newton_*/__pycache__/*.nbi"))
    second = run(environment)
    assert "compiling" not in second
    assert "converged" in second


def test_cache_in_no_writable_home_is_under_temp(tmp_path, monkeypatch):
    blocker = tmp_path / "file"
    blocker.write_text("")
    monkeypatch.setenv("XDG_CACHE_HOME", str(blocker))
    monkeypatch.setattr(compilation.tempfile, "gettempdir", lambda: str(tmp_path))
    assert compilation.cache_directory().parent == tmp_path


def test_sources_of_the_package_are_only_read(monkeypatch, tmp_path):
    folder = Path(compilation.__file__).parent / "newton"
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


def test_loading_is_quick_once_compiled(caplog):
    NewtonSolver(paper())
    with caplog.at_level(logging.INFO):
        begin = time.perf_counter()
        NewtonSolver(paper())
    assert time.perf_counter() - begin < 1.0
    assert not caplog.records


def test_draft_of_a_slower_process_is_dropped(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    sources = {"__init__.py": "", "stage.py": "N = 1\n"}
    first = compilation._installed("newton_test", sources)
    assert compilation._installed("newton_test", sources) == first
    assert [path.name for path in (tmp_path / "uav_tracking_mpc").iterdir()] == ["newton_test"]
    assert np.all([(first / name).read_text() == text for name, text in sources.items()])


@pytest.mark.parametrize("text", ["t0 = load 0 0", "store 0 0 1.0"])
def test_digest_changes_with_the_code(text):
    base = {"stage.py": "N = 1"}
    assert compilation._digest(base) != compilation._digest({"stage.py": text})
