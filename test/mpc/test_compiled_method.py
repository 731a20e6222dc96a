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

"""Compiled methods: made once, by one process, kept, loaded, given up."""

from __future__ import annotations

import dataclasses
import os
import signal
import subprocess
import sys
import threading
from functools import partial
from pathlib import Path
from types import SimpleNamespace

import pytest
from processes import wait_for
from solver_problems import PAPER_START, paper

from uav_tracking_mpc.mpc import compiled_method, machine_code
from uav_tracking_mpc.mpc.compiled_method import Compilation, CompilationError
from uav_tracking_mpc.mpc.newton_solver import NewtonSolver
from uav_tracking_mpc.symbolic import code_cache


@pytest.fixture
def broken(tmp_path):
    """Sources that cannot be compiled."""
    (tmp_path / "__init__.py").write_text("raise ValueError('no such instruction')\n")
    return tmp_path


def test_a_failure_is_one_line_that_names_the_folder(broken):
    with pytest.raises(CompilationError, match="could not be compiled in .*no such instruction"):
        Compilation(broken).wait()
    assert not machine_code.finished(broken)


def test_what_is_there_starts_no_process(broken):
    (broken / machine_code.DESCRIPTION).write_text("{}")
    compilation = Compilation(broken)
    assert compilation.done()
    assert compilation.seconds == 0.0
    compilation.wait()


@pytest.mark.skipif(sys.platform != "linux", reason="flock of Linux")
def test_a_lock_that_another_process_holds_is_waited_for_and_given_up(broken):
    import fcntl

    with (broken / machine_code.LOCK).open("a") as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        compilation = Compilation(broken)
        assert not compilation.done()
        compilation.close()
        with pytest.raises(CompilationError, match="given up"):
            compilation.done()


def test_without_file_locks_it_is_compiled_all_the_same(tmp_path, monkeypatch):
    fcntl = pytest.importorskip("fcntl")

    def refuse(*_):
        raise OSError("no locks available")

    monkeypatch.setattr(fcntl, "flock", refuse)
    monkeypatch.setattr(machine_code, "_end_with_input", lambda: None)
    monkeypatch.setattr(sys, "argv", ["machine_code", str(tmp_path)])
    made = []
    monkeypatch.setattr(machine_code, "make", made.append)
    assert machine_code.main() == 0
    assert made == [tmp_path]


def test_a_thread_that_waits_lets_the_program_end(broken, monkeypatch):
    compilation = Compilation(broken)
    monkeypatch.setattr(compilation, "done", lambda: False)
    monkeypatch.setattr(threading.main_thread(), "is_alive", lambda: False, raising=False)
    with pytest.raises(CompilationError, match="the program ends"):
        compilation.wait()


def test_a_child_that_writes_much_does_not_wait_for_a_reader(tmp_path):
    words = "import sys; sys.stderr.write('much\\n' * 100_000); raise ValueError('the end')\n"
    (tmp_path / "__init__.py").write_text(words)
    compilation = Compilation(tmp_path)
    assert wait_for(lambda: compilation._child.poll() is not None)
    with pytest.raises(CompilationError, match="the end"):
        compilation.done()


def test_a_compilation_outlives_the_thread_that_asked_for_it(tmp_path):
    fcntl = pytest.importorskip("fcntl")
    (tmp_path / "__init__.py").write_text("raise ValueError('it went on')\n")
    made = []
    with (tmp_path / machine_code.LOCK).open("a") as file:
        fcntl.flock(file, fcntl.LOCK_EX)  # the child waits for it
        thread = threading.Thread(target=lambda: made.append(Compilation(tmp_path)))
        thread.start()
        thread.join()
    with pytest.raises(CompilationError, match="it went on"):
        made[0].wait()


@pytest.fixture
def places(monkeypatch, tmp_path):
    """Cache of the user and directory for temporary files."""
    cache, temp = tmp_path / "cache", tmp_path / "temp"
    temp.mkdir()
    monkeypatch.setenv("XDG_CACHE_HOME", str(cache))
    monkeypatch.setattr(compiled_method.tempfile, "gettempdir", lambda: str(temp))
    return cache, temp


def test_without_a_writable_home_the_cache_is_under_temp(places):
    cache, temp = places
    cache.write_text("")  # no directory can be made there
    assert compiled_method.cache_directory().parent == temp


@pytest.fixture
def kept(places):
    """Folder with machine code in the cache of the user."""
    folder = compiled_method.method_folder(paper())
    (folder / machine_code.DESCRIPTION).write_text("{}")
    return folder


def test_what_is_compiled_is_found_where_nothing_can_be_written(places, kept, monkeypatch):
    cache, temp = places
    assert kept.parent.parent == cache
    monkeypatch.setattr(compiled_method, "cache_directory", lambda: temp)
    assert compiled_method.method_folder(paper()) == kept


def test_machine_code_of_another_user_is_not_run(kept, monkeypatch):
    found = kept.parent.stat()
    other = SimpleNamespace(st_uid=found.st_uid + 1, st_mode=found.st_mode)
    monkeypatch.setattr(compiled_method.os, "getuid", lambda: found.st_uid + 2)
    monkeypatch.setattr(Path, "stat", lambda path: other)
    assert not code_cache.ours(kept.parent)


@pytest.mark.parametrize("mode", [0o770, 0o707])
def test_machine_code_that_others_can_write_is_not_run(kept, mode):
    kept.parent.chmod(mode)
    assert compiled_method.method_folder(paper()).parent != kept.parent


def test_what_the_power_cut_off_is_made_anew(places):
    folder = compiled_method.method_folder(paper())
    whole = {file.name: file.read_bytes() for file in folder.iterdir()}
    for file in folder.iterdir():
        file.write_bytes(b"")
    (folder / machine_code.DESCRIPTION).write_text('{"size": 1, "obj')
    assert not machine_code.finished(folder)
    (folder / machine_code.DESCRIPTION).unlink()
    assert compiled_method.method_folder(paper()) == folder
    assert {file.name: file.read_bytes() for file in folder.iterdir()} == whole


def test_a_file_that_cannot_be_written_leaves_no_draft(tmp_path):
    (tmp_path / "stage.py").mkdir()
    with pytest.raises(OSError, match="stage.py"):
        code_cache.write(tmp_path / "stage.py", b"N = 1")
    assert [path.name for path in tmp_path.iterdir()] == ["stage.py"]


def test_the_name_changes_with_the_expressions_and_the_horizon_alone():
    problem = paper()

    def name(**changes):
        return compiled_method._digest(dataclasses.replace(problem, **changes))

    assert name() == compiled_method._digest(paper())
    assert name(input_upper=2.0 * problem.input_upper) == name()  # bounds are data
    others = {
        name(horizon=7),
        name(stage_cost=2.0 * problem.stage_cost),
        name(terminal_equality=problem.state[:1]),
    }
    assert len(others | {name()}) == 4


def test_the_name_changes_with_the_toolchain(monkeypatch):
    name = compiled_method._digest(paper())
    monkeypatch.setenv("NUMBA_CPU_NAME", "generic")
    monkeypatch.setattr(compiled_method, "_toolchain", compiled_method._toolchain.__wrapped__)
    assert compiled_method._digest(paper()) != name


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
from uav_tracking_mpc.symbolic import code_cache
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
    output, errors = process.communicate(timeout=900)
    assert process.returncode == 0, errors
    return output


def compiler_of(process: subprocess.Popen[str]) -> int:
    """Process id of the child that compiles."""
    found: list[str] = []

    def seen() -> bool:
        for task in Path(f"/proc/{process.pid}/task").glob("*/children"):
            found.extend(task.read_text().split())
        return bool(found)

    assert wait_for(seen), "nothing compiles"
    return int(found[0])


def gone(process: int) -> bool:
    """Whether a process has ended; one that nobody has waited for yet counts."""
    try:
        return Path(f"/proc/{process}/stat").read_text().rsplit(")", 1)[1].split()[0] == "Z"
    except OSError:
        return True


@pytest.mark.skipif(sys.platform != "linux", reason="reads /proc")
def test_a_signal_ends_the_wait_at_once_and_others_compile_once_for_all_that_come(tmp_path):
    """One test, because it compiles, which takes longer than all else here."""
    given_up, waiting = [], []
    for number in (signal.SIGINT, signal.SIGKILL):
        process = start(tmp_path)
        assert process.stdout is not None
        assert process.stdout.readline() == "begin\n"
        child = compiler_of(process)
        given_up.append(child)
        if number == signal.SIGKILL:
            waiting = [start(tmp_path) for _ in range(2)]
            for each in waiting:
                compiler_of(each)
        process.send_signal(number)
        process.communicate(timeout=900)
        assert process.returncode != 0
        assert wait_for(partial(gone, child)), "the compiler outlives the process that wants it"
        assert waiting or not list((tmp_path / "uav_tracking_mpc").glob("newton_*/method.json"))
    assert all("converged" in finish(process) for process in waiting)
    (folder,) = (tmp_path / "uav_tracking_mpc").glob("newton_*")
    assert {path.suffix for path in folder.iterdir() if path.is_file()} == {".py", ".json", ""}
    begun = {int(word) for word in (folder / "lock").read_text().split()}  # process ids
    assert len(begun - {*given_up}) == 1
    written = (folder / machine_code.DESCRIPTION).stat().st_mtime_ns
    later = finish(start(tmp_path))
    assert "compiling" not in later
    assert "converged" in later
    assert "False" in later
    assert (folder / machine_code.DESCRIPTION).stat().st_mtime_ns == written


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
