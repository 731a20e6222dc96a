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

"""The Newton method as machine code for one problem: compiled once, kept, loaded from the cache.

The code is called through its address, so what flies needs neither numba nor a compiler in its
process: LLVM links it in a few milliseconds, where numba takes half a second.

The cache has a folder for each problem. It holds the source files of the method and the
``stage.py`` generated for the problem, and, once they are compiled, the machine code. Its name is a
digest of all that goes into the machine code: the expressions of the problem, the sources, the
versions that compile them, the processor. So a change of any makes a new folder. Each file is
written in one step, and a process writes all sources before it compiles them, so that processes
which start together cannot read half a file, and sources that were damaged do not stay.
"""

from __future__ import annotations

import base64
import ctypes
import hashlib
import json
import logging
import os
import platform
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable
from functools import cache
from importlib import metadata, resources
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import casadi as ca
import numpy as np

from uav_tracking_mpc.mpc import machine_code, stage_code
from uav_tracking_mpc.mpc.problem import OptimalControlProblem
from uav_tracking_mpc.symbolic.code_cache import cache_directory, ours, places, write
from uav_tracking_mpc.symbolic.native_code import linked

logger = logging.getLogger(__name__)

POLL_PERIOD = 0.02  # s between looks while waiting
PATIENCE = 2.0  # s of waiting without a word
COURTESY = 10  # steps of `nice` by which others go first where a flight goes on meanwhile

BRIDGE = "ipopt"  # solves meanwhile


class CompilationError(RuntimeError):
    """The solver cannot be compiled; the message says why."""


class Compilation:
    """The machine code of a folder, made by a child process.

    The child ends with this process, whatever ends it, and leaves nothing half-made: the next
    process that needs the machine code makes it.

    Args:
        folder: With the method's sources.
        aside: Let everything else on the machine go first.

    Attributes:
        folder: With the method's sources.
    """

    def __init__(self, folder: Path, aside: bool = False) -> None:
        self.folder = folder
        self._begin = time.monotonic()
        self._seconds: float | None = None
        command = [sys.executable, "-m", machine_code.__name__, str(folder)]
        if aside and sys.platform == "linux":
            command = ["nice", "-n", str(COURTESY), *command]
        self._given_up = False
        self._child: subprocess.Popen[bytes] | None = None
        if machine_code.finished(folder):
            self._seconds = 0.0
            return
        # A file, not a pipe: a child that writes more than a pipe holds would wait for a reader.
        self._words = tempfile.TemporaryFile("w+", errors="replace")  # noqa: SIM115
        self._child = subprocess.Popen(
            command,
            stdin=subprocess.PIPE,  # ends with this process, and with it the child
            stdout=subprocess.DEVNULL,
            stderr=self._words,
            env={**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))},
            start_new_session=True,  # Ctrl-C reaches this process alone, which ends the child
        )

    @property
    def seconds(self) -> float:
        """How long it has taken in [s]: until now, or until it was seen to be done."""
        return time.monotonic() - self._begin if self._seconds is None else self._seconds

    def done(self) -> bool:
        """Whether the machine code is there; returns at once.

        Raises:
            CompilationError: The child failed, or it was given up.
        """
        if self._given_up:
            raise CompilationError("the compilation was given up")
        if self._child is None or self._seconds is not None:
            return True
        if self._child.poll() is None:
            return False
        self._child.communicate()  # closes its input
        self._seconds = self.seconds
        if not machine_code.finished(self.folder):
            self._words.seek(0)
            last = (
                self._words.read().strip().splitlines() or [f"exit code {self._child.returncode}"]
            )[-1]
            raise CompilationError(f"the solver could not be compiled in {self.folder}: {last}")
        return True

    def wait(self) -> None:
        """Return when the machine code is there; a signal interrupts at once.

        Raises:
            CompilationError: The child failed, or this process is about to end.
        """
        # Nobody is held up by a thread that waits beside the main one.
        told = threading.current_thread() is not threading.main_thread()
        silent = told
        try:
            while not self.done():
                time.sleep(POLL_PERIOD)
                if not told and self.seconds > PATIENCE:
                    told = True
                    logger.info(
                        "compiling the solver for this problem, once; kept in %s", self.folder
                    )
                if not threading.main_thread().is_alive():
                    raise CompilationError("the program ends before the solver is compiled")
        finally:
            self.close()
        if told and not silent:
            logger.info("solver compiled in %.1f s", self.seconds)

    def close(self) -> None:
        """Give it up, unless it is done."""
        if self._child is not None and self._child.poll() is None:
            self._given_up = True
            self._child.kill()
            self._child.communicate()


METHOD = "uav_tracking_mpc.mpc.newton"
COMPILERS = ("numba", "llvmlite", "numpy", "casadi")
# With which numba is told to compile for another processor.
PROCESSOR_VARIABLES = ("NUMBA_CPU_NAME", "NUMBA_CPU_FEATURES", "NUMBA_OPT")


def method_folder(problem: OptimalControlProblem) -> Path:
    """Folder with the sources of the method for a problem, with its machine code if that is made.

    Args:
        problem: What the method is to solve.

    Raises:
        NotImplementedError: An expression uses an operation that has no translation.
    """
    name = "newton_" + _digest(problem)
    for place in places():
        if ours(place) and machine_code.finished(place / name):
            return place / name
    folder = cache_directory() / name
    folder.mkdir(mode=0o700, exist_ok=True)
    for file, text in (*_method_sources(), ("stage.py", stage_code.stage_module(problem))):
        write(folder / file, text.encode())
    return folder


@cache
def _method_sources() -> tuple[tuple[str, str], ...]:
    files = resources.files(METHOD).iterdir()
    return tuple(
        sorted((f.name, f.read_text(encoding="utf-8")) for f in files if f.name.endswith(".py"))
    )


@cache
def _toolchain() -> str:
    """Digest of all that makes machine code of a problem, whatever the problem."""
    from llvmlite import binding

    digest = hashlib.sha256()
    parts = [sys.version, platform.machine(), *(metadata.version(name) for name in COMPILERS)]
    parts += [binding.get_host_cpu_name(), binding.get_host_cpu_features().flatten()]
    parts += [os.environ.get(variable, "") for variable in PROCESSOR_VARIABLES]
    for module in (stage_code, machine_code):
        parts.append(Path(str(module.__file__)).read_text(encoding="utf-8"))
    for name, text in _method_sources():
        parts += [name, text]
    for part in parts:
        digest.update(part.encode() + b"\0")
    return digest.hexdigest()


def _digest(problem: OptimalControlProblem) -> str:
    """Of the expressions as CasADi writes them: a hundredth of the time that their code takes."""
    expressions = ca.Function(
        "problem",
        [problem.state, problem.inputs, problem.parameter, problem.decision],
        [
            problem.next_state,
            problem.stage_cost,
            ca.vertcat(*(h.expression for h in problem.stage_inequalities)),
            problem.terminal_cost,
            problem.terminal_equality,
            ca.vertcat(*(h.expression for h in problem.terminal_inequalities)),
            problem.inputs if problem.continuation is None else problem.continuation,
        ],
    )
    text = f"{_toolchain()} {problem.horizon} {problem.continuation is None} "
    return hashlib.sha256((text + expressions.serialize()).encode()).hexdigest()[:20]


class CompiledMethod:
    """The method for one problem.

    Args:
        folder: Of the cache, with machine code.

    Attributes:
        stage: Constants of ``newton/stage.py``: the sizes of the problem.
        workspace: Those of ``newton/workspace.py``, and ``WORKSPACE``, its data type.
        minimise: Those of ``newton/minimise.py``: codes of how it begins and ends.
    """

    def __init__(self, folder: Path) -> None:
        description = json.loads((folder / machine_code.DESCRIPTION).read_text(encoding="utf-8"))
        constants = description["constants"]
        self.stage, self.workspace, self.minimise = (
            SimpleNamespace(**constants[name]) for name in machine_code.MODULES
        )
        fields = [(name, kind, tuple(shape)) for name, kind, shape in description["workspace"]]
        self.workspace.WORKSPACE = np.dtype(fields, align=True)
        if self.workspace.WORKSPACE.itemsize != description["size"]:
            raise RuntimeError(f"{folder} was written by another version of NumPy: delete it")
        objects = map(base64.b64decode, description["objects"])
        # It gives the interpreter's lock away.
        prototype = ctypes.CFUNCTYPE(ctypes.c_int64, ctypes.c_void_p)
        self._function = linked(objects, machine_code.ENTRY, prototype)

    def entry(self) -> Callable[[int, int, float, float, int, float, float], int]:
        """``minimise`` of ``newton/minimise.py``, for one caller: each has a block of arguments."""
        block = np.zeros(len(machine_code.ARGUMENTS), np.int64)
        integers: Any = memoryview(block)  # type: ignore[arg-type]
        floats: Any = memoryview(block.view(np.float64))  # type: ignore[arg-type]
        place, function = block.ctypes.data, self._function

        def minimise(
            address: int,
            start: int,
            stages: float,
            tolerance: float,
            iteration_limit: int,
            deadline: float,
            bound: float,
        ) -> int:
            integers[0], integers[1], floats[2] = address, start, stages
            floats[3], integers[4], floats[5] = tolerance, iteration_limit, deadline
            floats[6] = bound
            return function(place)

        return minimise


def compile_method(problem: OptimalControlProblem) -> CompiledMethod:
    """The method for a problem, compiled if it is not in the cache.

    Args:
        problem: What the method is to solve.

    Raises:
        NotImplementedError: An expression uses an operation that has no translation.
        CompilationError: The compiler failed.
    """
    folder = method_folder(problem)
    if not machine_code.finished(folder):
        Compilation(folder).wait()
    return load(folder)


@cache
def load(folder: Path) -> CompiledMethod:
    """The method of a folder; a second call returns the same.

    Args:
        folder: Of the cache, with machine code.
    """
    return CompiledMethod(folder)


class MachineCode:
    """The machine code for a problem, which is made meanwhile if it is not there.

    Args:
        problem: What is solved.
        report: Called with what happens, in words.
    """

    def __init__(self, problem: OptimalControlProblem, report: Callable[[str], None]) -> None:
        self._report, self._failed = report, False
        folder = method_folder(problem)
        self._compilation: Compilation | None = Compilation(folder, aside=True)
        self._made = machine_code.finished(folder)
        if not self._made:
            report(f"{BRIDGE} solves while the solver is compiled, once; kept in {folder}")

    @property
    def pending(self) -> bool:
        """Whether it is still being made."""
        return self._compilation is not None

    def __call__(self) -> bool:
        """Whether it is loaded; where it cannot be, that is said once and it never will be."""
        compilation = self._compilation
        if compilation is None:
            return not self._failed
        try:
            if not compilation.done():
                return False
            load(compilation.folder)
            if not self._made:
                words = f"solver compiled in {compilation.seconds:.1f} s; it solves from now on"
                self._report(words)
        except CompilationError as error:
            self._fail(str(error))
        except Exception as error:  # whatever LLVM says of what was compiled
            self._fail(f"the solver cannot be loaded: {type(error).__name__}: {error}")
        self._compilation = None
        return not self._failed

    def _fail(self, words: str) -> None:
        self._failed = True
        self._report(f"{words}; {BRIDGE} solves")
