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

import os
import sys
import threading

import pytest
from waiting import wait_for

from uav_tracking_mpc.mpc import machine_code
from uav_tracking_mpc.mpc.compilation import Compilation, CompilationError


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
    monkeypatch.setattr(machine_code, "_end_with_parent", lambda _: None)
    monkeypatch.setattr(sys, "argv", ["machine_code", str(tmp_path), str(os.getppid())])
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
