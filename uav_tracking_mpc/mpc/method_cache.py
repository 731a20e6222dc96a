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

"""Where the compiled solvers of a user are kept: a folder for each problem.

A folder holds the source files of the method and the ``stage.py`` generated for the problem, and,
once they are compiled, the machine code. Its name is a digest of all that goes into the machine
code: the expressions of the problem, the sources, the versions that compile them, the processor. So
a change of any makes a new folder. It is written under another name and moved into place, so that
processes which start together cannot read half a folder.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import platform
import shutil
import sys
import tempfile
from collections.abc import Iterator
from functools import cache
from importlib import metadata, resources
from pathlib import Path

import casadi as ca

from uav_tracking_mpc.mpc import machine_code, stage_code
from uav_tracking_mpc.mpc.problem import OptimalControlProblem

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
    for place in _places():
        if _ours(place) and machine_code.finished(place / name):
            return place / name
    folder = cache_directory() / name
    if not folder.is_dir():
        sources = _method_sources()
        sources["stage.py"] = stage_code.stage_module(problem)
        _install(folder, sources)
    return folder


def cache_directory() -> Path:
    """Writable directory for compiled solvers: XDG cache, or one of this user's under temp."""
    for place in _places():
        try:
            place.mkdir(mode=0o700, parents=True, exist_ok=True)
            with tempfile.TemporaryFile(dir=place):
                pass
        except OSError:
            continue
        if _ours(place):
            return place
    return _last_resort()


def _places() -> Iterator[Path]:
    """Where compiled solvers may be; the first one that can be written takes new ones."""
    base = os.environ.get("XDG_CACHE_HOME") or "~/.cache"
    with contextlib.suppress(RuntimeError):  # nobody knows where this user's home is
        yield Path(base).expanduser() / "uav_tracking_mpc"
    user = os.getuid() if hasattr(os, "getuid") else "user"
    yield Path(tempfile.gettempdir()) / f"uav_tracking_mpc-{user}"


@cache
def _last_resort() -> Path:
    return Path(tempfile.mkdtemp(prefix="uav_tracking_mpc-"))


def _ours(place: Path) -> bool:
    """Whether nobody but this user and root can have written there: machine code is run from it."""
    if not hasattr(os, "getuid"):
        return True
    try:
        found = place.stat()
        return found.st_uid in (os.getuid(), 0) and not found.st_mode & 0o022
    except OSError:
        return False


@cache
def _method_sources_read() -> tuple[tuple[str, str], ...]:
    files = resources.files(METHOD).iterdir()
    return tuple(
        sorted((f.name, f.read_text(encoding="utf-8")) for f in files if f.name.endswith(".py"))
    )


def _method_sources() -> dict[str, str]:
    return dict(_method_sources_read())


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
    for name, text in _method_sources_read():
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


def _install(folder: Path, sources: dict[str, str]) -> None:
    """Write a folder with these sources, unless another process is faster."""
    draft = Path(tempfile.mkdtemp(prefix=f"{folder.name}.", dir=folder.parent))
    try:
        for file, text in sources.items():
            (draft / file).write_text(text, encoding="utf-8")
        draft.rename(folder)
    except OSError:
        if not folder.is_dir():
            raise
    finally:
        shutil.rmtree(draft, ignore_errors=True)
