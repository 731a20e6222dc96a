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

"""How the method is compiled: options, the clock, and straight-line code as machine code.

A program is text such as ::

    t0 = load 0 1
    t1 = sin t0
    store 2 3 t1

which writes the sine of element 1 of input 0 to element 3 of output 2.

numba could compile the same lines written as Python, but its type inference takes 2 ms a line and
the derivatives of a Runge-Kutta step have thousands. Everything here is a float64, so nothing needs
inferring: each line becomes one LLVM instruction.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from llvmlite import ir
from numba import njit, types
from numba.core import cgutils
from numba.extending import intrinsic

# Sums may be reordered and fused; NaN and infinity keep their meaning, for the line search.
# _nrt=False: no reference counting, so code that would allocate does not compile.
OPTIONS = {
    "error_model": "numpy",
    "fastmath": {"contract", "reassoc", "nsz", "arcp"},
    "_nrt": False,
}
compiled = njit(**OPTIONS, no_cpython_wrapper=True, no_cfunc_wrapper=True)
placed = njit(**OPTIONS, inline="always")  # into its caller, not compiled by itself
entry = njit(**OPTIONS, no_cfunc_wrapper=True, nogil=True)


MONOTONIC = 1  # code of CLOCK_MONOTONIC, POSIX on Linux

_clock_gettime = types.ExternalFunction("clock_gettime", types.int32(types.int32, types.uintp))


@compiled
def now(instant):
    """Seconds on the monotonic clock.

    Args:
        instant: Two int64 that the C library fills with seconds and nanoseconds.
    """
    _clock_gettime(MONOTONIC, instant.ctypes.data)
    return instant[0] + 1e-9 * instant[1]


DOUBLE = ir.DoubleType()
FAST = ("contract", "reassoc", "nsz", "arcp")  # not nnan, ninf: rejected steps rely on NaN
INTRINSICS = {  # operations that LLVM knows; the others are functions of the C library
    "fmin": "minnum", "fmax": "maxnum",
    **{name: name for name in ("sqrt", "sin", "cos", "exp", "log", "fabs", "floor", "ceil")},
    "pow": "pow", "copysign": "copysign",
}  # fmt: skip
COMPARISONS = {"lt": "<", "le": "<=", "eq": "==", "ne": "!="}


def straight_line(program: str) -> Callable[..., None]:
    """Function for compiled code that runs a program.

    Args:
        program: Lines ``target = load input element``, ``target = operation operands`` and
            ``store output element value``; an operand is an earlier target or a number.

    Returns:
        ``run((inputs...), (outputs...))``: two tuples of contiguous float64 arrays; the program
        addresses their elements by flat index.
    """

    @intrinsic
    def run(typing_context: Any, inputs: Any, outputs: Any) -> Any:
        def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            pointers = [
                [
                    context.make_array(array)(
                        context, builder, builder.extract_value(value, index)
                    ).data
                    for index, array in enumerate(tuple_type)
                ]
                for tuple_type, value in zip(signature.args, arguments, strict=True)
            ]
            _Translation(builder, *pointers).translate(program)
            return context.get_dummy_value()

        return types.void(inputs, outputs), generate

    return run


class _Translation:
    """LLVM instructions for the lines of one program."""

    def __init__(self, builder: Any, inputs: list[Any], outputs: list[Any]) -> None:
        self._builder = builder
        self._inputs = inputs
        self._outputs = outputs
        self._values: dict[str, Any] = {}

    def translate(self, program: str) -> None:
        for line in program.splitlines():
            words = line.split("#")[0].split()
            if not words:
                continue
            if words[0] == "store":
                output, element, value = words[1:]
                self._builder.store(
                    self._value(value), self._element(self._outputs[int(output)], int(element))
                )
            else:
                target, _, operation, *operands = words
                self._values[target] = self._operation(operation, operands)

    def _element(self, pointer: Any, index: int) -> Any:
        return cgutils.gep_inbounds(self._builder, pointer, index)

    def _value(self, word: str) -> Any:
        return self._values[word] if word in self._values else ir.Constant(DOUBLE, float(word))

    def _operation(self, operation: str, operands: list[str]) -> Any:
        builder = self._builder
        if operation == "load":
            source, element = (int(word) for word in operands)
            return builder.load(self._element(self._inputs[source], element))
        values = [self._value(word) for word in operands]
        if operation in ("add", "sub", "mul", "div"):
            return getattr(builder, f"f{operation}")(*values, flags=FAST)
        if operation == "neg":
            return builder.fneg(values[0], flags=FAST)
        if operation in COMPARISONS:
            truth = builder.fcmp_ordered(COMPARISONS[operation], *values)
            return builder.uitofp(truth, DOUBLE)
        if operation == "choose":  # choose condition value: value where condition, else 0
            nonzero = builder.fcmp_unordered("!=", values[0], ir.Constant(DOUBLE, 0.0))
            return builder.select(nonzero, values[1], ir.Constant(DOUBLE, 0.0))
        kind = ir.FunctionType(DOUBLE, [DOUBLE] * len(values))
        name = f"llvm.{INTRINSICS[operation]}.f64" if operation in INTRINSICS else operation
        function = cgutils.get_or_insert_function(builder.module, kind, name)
        return builder.call(function, values)
