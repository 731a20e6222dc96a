"""Compile the Newton method for one problem, or load it from the user's cache.

The method's source files are copied, beside the ``stage.py`` generated for the problem, into a
folder of their own under the cache directory and imported from there; numba keeps the machine code
next to them. The folder's name is a digest of every source line and of the versions that made it,
so a change of any makes a new one. It is written under another name and moved into place, so
processes that start together cannot read half a folder.
"""

from __future__ import annotations

import hashlib
import importlib
import importlib.util
import logging
import os
import platform
import shutil
import sys
import tempfile
import time
from importlib import resources
from pathlib import Path
from types import ModuleType

import numpy as np

from uav_tracking_mpc.mpc.problem import OptimalControlProblem
from uav_tracking_mpc.mpc.stage_code import stage_module

logger = logging.getLogger(__name__)

METHOD = "uav_tracking_mpc.mpc.newton"
FINISHED = "compiled"  # marks a folder whose machine code is there


def compile_method(problem: OptimalControlProblem) -> ModuleType:
    """Package whose modules are the Newton method for this problem, compiled.

    Args:
        problem: What the method is to solve.

    Raises:
        NotImplementedError: An expression uses an operation that has no translation.
    """
    sources = _method_sources()
    sources["stage.py"] = stage_module(problem)
    name = "newton_" + _digest(sources)
    if name in sys.modules:
        return sys.modules[name]
    folder = _installed(name, sources)
    begin = time.perf_counter()
    fresh = not (folder / FINISHED).exists()
    if fresh:
        logger.info("compiling the solver for this problem, once; kept in %s", folder)
    package = _import_package(name, folder)
    for module in ("workspace", "minimise"):
        importlib.import_module(f"{name}.{module}")
    workspace = np.zeros(1, package.workspace.WORKSPACE)
    workspace["x_0"] = np.nan  # refused at once: the call only compiles
    package.minimise.minimise(workspace.ctypes.data, package.minimise.WARM, 0.0, 1e-6, 1, 1.0)
    if fresh:
        (folder / FINISHED).touch()
        logger.info("solver compiled in %.1f s", time.perf_counter() - begin)
    return package


def cache_directory() -> Path:
    """Writable directory for compiled solvers: XDG cache, or one of this user's under temp."""
    base = os.environ.get("XDG_CACHE_HOME") or "~/.cache"
    candidates = [Path(base).expanduser() / "uav_tracking_mpc"]
    user = os.getuid() if hasattr(os, "getuid") else "user"
    candidates.append(Path(tempfile.gettempdir()) / f"uav_tracking_mpc-{user}")
    for candidate in candidates:
        try:
            candidate.mkdir(mode=0o700, parents=True, exist_ok=True)
            with tempfile.TemporaryFile(dir=candidate):
                pass
        except OSError:
            continue
        if not hasattr(os, "getuid") or candidate.stat().st_uid == os.getuid():
            return candidate
    return Path(tempfile.mkdtemp(prefix="uav_tracking_mpc-"))


def _method_sources() -> dict[str, str]:
    files = resources.files(METHOD).iterdir()
    return {
        file.name: file.read_text(encoding="utf-8") for file in files if file.name.endswith(".py")
    }


def _digest(sources: dict[str, str]) -> str:
    import llvmlite
    import numba

    digest = hashlib.sha256()
    versions = (sys.version, numba.__version__, llvmlite.__version__, np.__version__)
    for text in (*versions, platform.machine()):
        digest.update(text.encode() + b"\\0")
    for name in sorted(sources):
        digest.update(name.encode() + b"\\0" + sources[name].encode() + b"\\0")
    return digest.hexdigest()[:20]


def _installed(name: str, sources: dict[str, str]) -> Path:
    """Folder of that name with these sources, written if it is not there."""
    cache = cache_directory()
    folder = cache / name
    if folder.is_dir():
        return folder
    draft = Path(tempfile.mkdtemp(prefix=f"{name}.", dir=cache))
    for file, text in sources.items():
        (draft / file).write_text(text, encoding="utf-8")
    try:
        draft.rename(folder)
    except OSError:  # another process was faster
        shutil.rmtree(draft, ignore_errors=True)
    return folder


def _import_package(name: str, folder: Path) -> ModuleType:
    specification = importlib.util.spec_from_file_location(
        name, folder / "__init__.py", submodule_search_locations=[str(folder)]
    )
    assert specification is not None and specification.loader is not None
    package = importlib.util.module_from_spec(specification)
    sys.modules[name] = package
    specification.loader.exec_module(package)
    return package
