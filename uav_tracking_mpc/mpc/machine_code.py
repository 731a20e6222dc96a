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

"""Make the machine code of a folder with the method's sources: a process of its own.

It runs as ``python -m uav_tracking_mpc.mpc.machine_code FOLDER``, because compiling takes seconds
in which nothing else runs in a process and no signal is heard. However many processes want the same
machine code, one makes it: each starts this one, which first waits for a lock. It ends with its
input, which its parent holds open for as long as it lives. All of it is one file of JSON, written
under its name in one step: what is cut off, as where the power failed, cannot be read, and counts
as not made.
"""

from __future__ import annotations

import base64
import contextlib
import importlib
import importlib.util
import json
import os
import sys
import threading
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

from uav_tracking_mpc.symbolic.code_cache import write

DESCRIPTION = "method.json"
LOCK = "lock"
MODULES = ("stage", "workspace", "minimise")  # whose constants callers read
ENTRY = "minimise"  # function of the module of that name
# Its arguments and what it returns, 64-bit numbers each. They are handed over in a block of memory,
# because a call from Python costs by the argument.
ARGUMENTS = ("int64", "int64", "float64", "float64", "int64", "float64", "float64")
RESULT = "int64"
PACKAGE = "newton_method"


def finished(folder: Path) -> bool:
    """Whether the machine code is there.

    Args:
        folder: With the method's sources.
    """
    try:
        json.loads((folder / DESCRIPTION).read_bytes())
    except (OSError, ValueError):
        return False
    return True


def main() -> int:
    """Entry point; exit code 0 when the machine code is there."""
    folder = Path(sys.argv[1])
    threading.Thread(target=_end_with_input, daemon=True).start()
    with _locked(folder / LOCK):
        if not finished(folder):
            with (folder / LOCK).open("a") as file:
                file.write(f"{os.getpid()}\n")  # who has compiled
            make(folder)
    return 0


def make(folder: Path) -> None:
    """Compile and write.

    Args:
        folder: With the method's sources; gets the machine code.
    """
    package = _imported(folder)
    modules = {name: importlib.import_module(f"{PACKAGE}.{name}") for name in MODULES}
    assert package is not None
    method, name = _compiled(modules[ENTRY])
    workspace = modules["workspace"].WORKSPACE
    description = {
        "constants": {name: _constants(module) for name, module in modules.items()},
        "workspace": [
            [field, workspace[field].base.str, list(workspace[field].shape)]
            for field in workspace.names
        ],
        "size": workspace.itemsize,
        "objects": [base64.b64encode(content).decode() for content in (method, _entry(name))],
    }
    write(folder / DESCRIPTION, json.dumps(description).encode())


def _end_with_input() -> None:
    os.read(sys.stdin.fileno(), 1)
    os._exit(1)


@contextlib.contextmanager
def _locked(path: Path) -> Iterator[None]:
    """Alone among the processes that use this lock, where the file system knows locks.

    Where it knows none, several processes may make the same files, each in one step.
    """
    with contextlib.ExitStack() as stack:
        with contextlib.suppress(ImportError, OSError):
            import fcntl

            file = stack.enter_context(path.open("a"))
            fcntl.flock(file, fcntl.LOCK_EX)
        yield


def _imported(folder: Path) -> ModuleType:
    specification = importlib.util.spec_from_file_location(
        PACKAGE, folder / "__init__.py", submodule_search_locations=[str(folder)]
    )
    assert specification is not None and specification.loader is not None
    package = importlib.util.module_from_spec(specification)
    sys.modules[PACKAGE] = package
    specification.loader.exec_module(package)
    return package


def _compiled(module: ModuleType) -> tuple[bytes, str]:
    """Machine code of the entry as an object file, and the symbol under which it is there."""
    from numba import njit, types

    options = importlib.import_module(f"{PACKAGE}.compiling").OPTIONS
    function = getattr(module, ENTRY).py_func
    # Without the wrapper for Python, which would need numba where it is loaded.
    bare = njit(**options, no_cpython_wrapper=True, no_cfunc_wrapper=True)(function)
    signature = tuple(getattr(types, kind) for kind in ARGUMENTS)
    bare.compile(signature)
    result = bare.overloads[signature]
    if str(result.signature.return_type) != RESULT:
        raise TypeError(f"{ENTRY} returns {result.signature.return_type}, must be {RESULT}")
    _, _, (content, _) = result.library.serialize_using_object_code()
    return content, result.fndesc.llvm_func_name


def _entry(name: str) -> bytes:
    """Object file with the function as C calls it: address of the arguments in, number out."""
    from llvmlite import binding, ir

    kinds: dict[str, Any] = {"int64": ir.IntType(64), "float64": ir.DoubleType()}
    arguments, result = [kinds[kind] for kind in ARGUMENTS], kinds[RESULT]
    module = ir.Module("entry")
    module.triple = binding.get_process_triple()
    pointer = ir.IntType(8).as_pointer()
    native = ir.Function(
        module,
        ir.FunctionType(ir.IntType(32), [result.as_pointer(), pointer.as_pointer(), *arguments]),
        name,
    )
    function = ir.Function(module, ir.FunctionType(result, [pointer]), ENTRY)
    builder = ir.IRBuilder(function.append_basic_block())
    values = []
    for index, kind in enumerate(arguments):
        place = builder.gep(function.args[0], [ir.Constant(ir.IntType(64), 8 * index)])
        values.append(builder.load(builder.bitcast(place, kind.as_pointer())))
    answer, exception = builder.alloca(result), builder.alloca(pointer)
    status = builder.call(native, [answer, exception, *values])
    fine = builder.icmp_signed("==", status, ir.Constant(ir.IntType(32), 0))
    # Nothing in the method raises; -1 is no code of its.
    builder.ret(builder.select(fine, builder.load(answer), ir.Constant(result, -1)))
    binding.initialize_native_target()
    binding.initialize_native_asmprinter()
    machine = binding.Target.from_triple(module.triple).create_target_machine(
        opt=2, codemodel="jitdefault", jit=True
    )
    content: bytes = machine.emit_object(binding.parse_assembly(str(module)))
    return content


def _constants(module: ModuleType) -> dict[str, int | float]:
    """Numbers that a module names in capitals."""
    import numpy as np

    found: dict[str, int | float] = {}
    for name, value in vars(module).items():
        if name.isupper() and isinstance(value, (int, float, np.integer, np.floating)):
            found[name] = value if isinstance(value, (int, float)) else value.item()
    return found


if __name__ == "__main__":
    sys.exit(main())
