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

"""The Newton method as machine code for one problem, loaded from the user's cache.

The code is called through its address, so what flies needs neither numba nor a compiler in its
process: LLVM links it in a few milliseconds, where numba takes half a second.
"""

from __future__ import annotations

import ctypes
import json
from collections.abc import Callable
from functools import cache
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np

from uav_tracking_mpc.mpc import machine_code
from uav_tracking_mpc.mpc.compilation import Compilation
from uav_tracking_mpc.mpc.method_cache import method_folder
from uav_tracking_mpc.mpc.problem import OptimalControlProblem


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
        self._function = self._linked(folder)

    def entry(self) -> Callable[[int, int, float, float, int, float], int]:
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
        ) -> int:
            integers[0], integers[1], floats[2] = address, start, stages
            floats[3], integers[4], floats[5] = tolerance, iteration_limit, deadline
            return function(place)

        return minimise

    def _linked(self, folder: Path) -> Callable[[int], int]:
        from llvmlite import binding

        binding.initialize_native_target()
        binding.initialize_native_asmprinter()
        machine = binding.Target.from_default_triple().create_target_machine(
            codemodel="jitdefault", jit=True
        )
        self._engine = binding.create_mcjit_compiler(binding.parse_assembly(""), machine)
        for name in machine_code.OBJECTS:
            content = (folder / name).read_bytes()
            self._engine.add_object_file(binding.ObjectFileRef.from_data(content))
        self._engine.finalize_object()
        prototype = ctypes.CFUNCTYPE(ctypes.c_int64, ctypes.c_void_p)  # releases the GIL
        return prototype(self._engine.get_function_address(machine_code.ENTRY))


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
