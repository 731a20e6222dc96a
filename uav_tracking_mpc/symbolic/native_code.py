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

"""CasADi functions as machine code: the same numbers to the last bit, in a tenth of the time.

CasADi goes through the operations of a function one by one. LLVM translates them as they stand:
nothing is reordered or fused, and functions of the C library are called as CasADi calls them. That
takes tenths of a second for thousands of operations. It is done once, in a thread, while CasADi
evaluates; what has been made is kept, and loaded in milliseconds from then on.
"""

from __future__ import annotations

import contextlib
import ctypes
import functools
import hashlib
import logging
import threading
import weakref
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
from llvmlite import binding, ir
from numpy.typing import NDArray

from uav_tracking_mpc.symbolic.code_cache import cache_directory, ours, places, write
from uav_tracking_mpc.symbolic.functions import BufferedFunction, walk

logger = logging.getLogger(__name__)

ENTRY = "run"  # of the machine code
DOUBLE, INDEX = ir.DoubleType(), ir.IntType(64)
ARITHMETIC = {ca.OP_ADD: "fadd", ca.OP_SUB: "fsub", ca.OP_MUL: "fmul", ca.OP_DIV: "fdiv"}
COMPARISONS = {ca.OP_LT: "<", ca.OP_LE: "<=", ca.OP_EQ: "=="}
INTRINSICS = {  # that are exact
    ca.OP_SQRT: "sqrt", ca.OP_FABS: "fabs", ca.OP_FLOOR: "floor", ca.OP_CEIL: "ceil"
}  # fmt: skip
LIBRARY = {
    ca.OP_SIN: "sin", ca.OP_COS: "cos", ca.OP_TAN: "tan", ca.OP_ASIN: "asin", ca.OP_ACOS: "acos",
    ca.OP_ATAN: "atan", ca.OP_ATAN2: "atan2", ca.OP_EXP: "exp", ca.OP_LOG: "log",
    ca.OP_POW: "pow", ca.OP_CONSTPOW: "pow", ca.OP_FMOD: "fmod", ca.OP_REMAINDER: "remainder",
    ca.OP_HYPOT: "hypot", ca.OP_EXPM1: "expm1", ca.OP_LOG1P: "log1p", ca.OP_COPYSIGN: "copysign",
}  # fmt: skip


class NativeFunction(BufferedFunction):
    """A function on arrays of its own, as machine code as soon as there is some.

    CasADi goes on with one that has an operation without a translation, as a user's model may.

    Args:
        function: Of dense arguments and results.
        arguments: See :class:`BufferedFunction`.
    """

    def __init__(
        self, function: ca.Function, arguments: Sequence[NDArray[np.float64] | None] = ()
    ) -> None:
        super().__init__(function, arguments)
        self._code: MachineCode | None = None
        with contextlib.suppress(NotImplementedError):
            self._code = machine_code(function)
        arrays = [*self.arguments, *self.results]
        self._addresses = np.array([array.ctypes.data for array in arrays], np.uintp)
        self._place = self._addresses.ctypes.data

    def evaluate(self) -> None:
        """Write the results of the arguments as they are."""
        code = self._code
        if code is None or code.run is None:
            super().evaluate()
        else:
            code.run(self._place)


class MachineCode:
    """Of one function.

    Args:
        function: Of dense arguments and results.

    Attributes:
        run: Evaluates it, called with the address of the addresses of all its arguments and
            results; None until it is made.
        thread: Makes it; None where it was there.

    Raises:
        NotImplementedError: The function has an operation that has no translation.
    """

    def __init__(self, function: ca.Function) -> None:
        self.run: Callable[[int], None] | None = None
        self.thread: threading.Thread | None = None
        name = f"{function.name()}_{_digest(function)}"
        for place in places():
            if ours(place) and (content := _kept(place / name)) is not None:
                self._link(content)
                return
        # A program that ends waits for it: LLVM must not be at work when it is taken down.
        self.thread = threading.Thread(target=self._make, args=(assembly(function), name))
        self.thread.start()

    def _make(self, program: str, name: str) -> None:
        try:
            content = _machine().emit_object(binding.parse_assembly(program))
            self._link(content)
            write(cache_directory() / name, hashlib.sha256(content).digest() + content)
        except Exception as error:  # whatever LLVM or the file system says
            what = "made, CasADi goes on" if self.run is None else "kept"
            logger.warning("machine code of %s is not %s: %s", name, what, error)

    def _link(self, content: bytes) -> None:
        # It holds the interpreter's lock: to get it again could take longer than the function.
        self.run = linked([content], ENTRY, ctypes.PYFUNCTYPE(None, ctypes.c_void_p))


# A function may be one of many, such as that of a node which is configured again and again: it is
# let go of with what uses it.
_MADE: weakref.WeakKeyDictionary[ca.Function, MachineCode] = weakref.WeakKeyDictionary()


def machine_code(function: ca.Function) -> MachineCode:
    """The machine code of a function; a second call returns the same.

    Args:
        function: Of dense arguments and results.

    Raises:
        NotImplementedError: It has an operation that has no translation.
    """
    if function not in _MADE:
        _MADE[function] = MachineCode(function)
    return _MADE[function]


def linked(objects: Iterable[bytes], entry: str, prototype: Callable[[int], Any]) -> Any:
    """A function of object files, ready to be called.

    Args:
        objects: Contents of the files.
        entry: Its name.
        prototype: Of ``ctypes``.
    """
    engine = binding.create_mcjit_compiler(binding.parse_assembly(""), _machine())
    for content in objects:
        engine.add_object_file(binding.ObjectFileRef.from_data(content))
    engine.finalize_object()
    function = prototype(engine.get_function_address(entry))
    function.engine = engine  # type: ignore[attr-defined]  # the code lives as long as it does
    return function


def _machine() -> binding.TargetMachine:
    binding.initialize_native_target()
    binding.initialize_native_asmprinter()
    target = binding.Target.from_default_triple()
    # To optimise takes up to forty times as long, in which a node may wait for LLVM to load its
    # solver, and makes a step of the controller faster by a hundredth.
    return target.create_target_machine(opt=0, codemodel="jitdefault", jit=True)


@functools.cache
def _triple() -> str:
    """Of this machine, asked for once: LLVM's answer waits for what it translates in a thread."""
    return binding.get_process_triple()  # type: ignore[no-any-return]


@functools.cache
def _maker() -> str:
    """All that makes machine code of a function."""
    return f"{_triple()} {binding.llvm_version_info} {Path(__file__).read_text()}"


def _digest(function: ca.Function) -> str:
    """Of the function, and of all that makes machine code of it."""
    text = f"{_maker()} {function.serialize()}"
    return hashlib.sha256(text.encode()).hexdigest()[:20]


def _kept(path: Path) -> bytes | None:
    """Machine code of a file; None where there is none, or it is not whole."""
    try:
        content = path.read_bytes()
    except OSError:
        return None
    digest, content = content[:32], content[32:]
    return content if hashlib.sha256(content).digest() == digest else None


def assembly(function: ca.Function) -> str:
    """A function in LLVM's language, as ``run(addresses)``.

    Args:
        function: Of dense arguments and results.

    Raises:
        NotImplementedError: It has an operation that has no translation.
    """
    module = ir.Module(function.name())
    module.triple = _triple()
    pointers = DOUBLE.as_pointer().as_pointer()
    entry = ir.Function(module, ir.FunctionType(ir.VoidType(), [pointers]), ENTRY)
    builder = ir.IRBuilder(entry.append_basic_block())

    def constant(value: float) -> ir.Constant:
        return ir.Constant(DOUBLE, value)

    arrays = [
        builder.load(builder.gep(entry.args[0], [ir.Constant(INDEX, which)]))
        for which in range(function.n_in() + function.n_out())
    ]

    def place(array: int, element: int) -> Any:
        return builder.gep(arrays[array], [ir.Constant(INDEX, element)])

    def store(output: int, element: int, value: Any) -> None:
        builder.store(value, place(function.n_in() + output, element))

    walk(
        function,
        lambda input_, element: builder.load(place(input_, element)),
        constant,
        functools.partial(_applied, builder),
        store,
    )
    builder.ret_void()
    return str(module)


def _applied(builder: ir.IRBuilder, code: int, *values: Any) -> Any:
    """What an operation of CasADi makes of its operands."""
    x, zero, one = values[0], ir.Constant(DOUBLE, 0.0), ir.Constant(DOUBLE, 1.0)

    def holds(value: Any) -> Any:  # as in C, no number holds
        return builder.fcmp_unordered("!=", value, zero)

    def number(truth: Any) -> Any:
        return builder.uitofp(truth, DOUBLE)

    def beyond(comparison: str) -> Any:  # of two numbers that are equal the first one
        instead = builder.fcmp_ordered(comparison, values[1], x)
        return builder.select(
            builder.or_(instead, builder.fcmp_unordered("uno", x, x)), values[1], x
        )

    if code in ARITHMETIC:
        return getattr(builder, ARITHMETIC[code])(*values)
    if code in COMPARISONS:
        return number(builder.fcmp_ordered(COMPARISONS[code], *values))
    if code in INTRINSICS:
        name = INTRINSICS[code]
        return builder.call(builder.module.declare_intrinsic(f"llvm.{name}", [DOUBLE]), values)
    if code in LIBRARY:
        kind = ir.FunctionType(DOUBLE, [DOUBLE] * len(values))
        known = builder.module.globals.get(LIBRARY[code])
        return builder.call(known or ir.Function(builder.module, kind, LIBRARY[code]), values)
    composed: dict[int, Callable[[], Any]] = {
        ca.OP_FMIN: lambda: beyond("<"),
        ca.OP_FMAX: lambda: beyond(">"),
        ca.OP_NE: lambda: number(builder.fcmp_unordered("!=", *values)),
        ca.OP_NEG: lambda: builder.fneg(x),
        ca.OP_SQ: lambda: builder.fmul(x, x),
        ca.OP_TWICE: lambda: builder.fadd(x, x),
        ca.OP_INV: lambda: builder.fdiv(one, x),
        ca.OP_NOT: lambda: number(builder.fcmp_ordered("==", x, zero)),
        ca.OP_AND: lambda: number(builder.and_(*map(holds, values))),
        ca.OP_OR: lambda: number(builder.or_(*map(holds, values))),
        ca.OP_IF_ELSE_ZERO: lambda: builder.select(holds(x), values[1], zero),
        ca.OP_SIGN: lambda: builder.select(
            builder.fcmp_ordered("<", x, zero),
            ir.Constant(DOUBLE, -1.0),
            builder.select(builder.fcmp_ordered("<", zero, x), one, x),
        ),
    }
    if code not in composed:
        raise NotImplementedError(f"operation {code} of CasADi has no translation")
    return composed[code]()
