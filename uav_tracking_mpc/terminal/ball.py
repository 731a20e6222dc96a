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

r"""CasADi functions in ball arithmetic: a real number is a midpoint and a radius that holds it.

The models stand once, as CasADi expressions. A CasADi ``Function`` of SX type is a list of
elementary instructions; walking that list with Arb's balls (python-flint) instead of floating-point
numbers gives an enclosure of the function's range over a box, and of its derivatives, which CasADi
derives. Every operation rounds outwards, so an enclosure is a theorem about real numbers:

.. math:: x \in X \;\Rightarrow\; \phi(x) \in \Phi(X)

A division by a ball that holds 0, or the root of one that holds negative numbers, gives a ball of
infinite radius or ``nan``; every comparison with it is false, so nothing can be concluded from it.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Sequence
from typing import Any

import casadi as ca

PRECISION = 96  # bits of the midpoints: rounding is then far below the radius of any box


def flint() -> Any:
    """The python-flint module, imported when a proof first needs it.

    Raises:
        ImportError: python-flint is not installed; the message says how to get it.
    """
    try:
        import flint as module
    except ImportError as error:
        raise ImportError(
            "the proof needs python-flint (ball arithmetic): pip install 'uav_tracking_mpc[proof]' "
            "or pip install python-flint"
        ) from error
    return module


_UNARY: dict[int, Callable[[Any], Any]] = {
    ca.OP_ASSIGN: lambda a: a,
    ca.OP_NEG: operator.neg,
    ca.OP_SQ: lambda a: a * a,
    ca.OP_TWICE: lambda a: a + a,
    ca.OP_INV: lambda a: 1 / a,
    ca.OP_SQRT: lambda a: a.sqrt(),
    ca.OP_SIN: lambda a: a.sin(),
    ca.OP_COS: lambda a: a.cos(),
    ca.OP_TAN: lambda a: a.tan(),
    ca.OP_EXP: lambda a: a.exp(),
}
_BINARY: dict[int, Callable[[Any, Any], Any]] = {
    ca.OP_ADD: operator.add,
    ca.OP_SUB: operator.sub,
    ca.OP_MUL: operator.mul,
    ca.OP_DIV: operator.truediv,
}


class BallFunction:
    """A CasADi function, evaluated on balls.

    Args:
        function: Of SX type; constants in it are taken as the exact doubles that they are.

    Raises:
        NotImplementedError: It has an operation that is not known here.
    """

    def __init__(self, function: ca.Function) -> None:
        arb = flint().arb
        self.sizes = [function.nnz_out(i) for i in range(function.n_out())]
        self._work_size = function.sz_w()
        self._program: list[tuple[int, Any, int, int, int]] = []
        for k in range(function.n_instructions()):
            code = function.instruction_id(k)
            ins, outs = function.instruction_input(k), function.instruction_output(k)
            if code == ca.OP_CONST:
                self._program.append((0, arb(function.instruction_constant(k)), outs[0], 0, 0))
            elif code == ca.OP_INPUT:
                self._program.append((1, None, outs[0], ins[0], ins[1]))
            elif code == ca.OP_OUTPUT:
                self._program.append((2, None, ins[0], outs[0], outs[1]))
            elif code in _UNARY:
                self._program.append((3, _UNARY[code], outs[0], ins[0], 0))
            elif code in _BINARY:
                self._program.append((4, _BINARY[code], outs[0], ins[0], ins[1]))
            else:
                raise NotImplementedError(
                    f"operation {code} of {function.name()} has no enclosure here"
                )

    def __call__(self, *inputs: Sequence[Any]) -> list[list[Any]]:
        """Enclose the outputs.

        Args:
            inputs: One list of balls for each input of the function, its nonzeros in order.

        Returns:
            For each output the balls of its nonzeros.
        """
        work: list[Any] = [None] * self._work_size
        outputs: list[list[Any]] = [[None] * size for size in self.sizes]
        for kind, what, a, b, c in self._program:
            if kind == 4:
                work[a] = what(work[b], work[c])
            elif kind == 3:
                work[a] = what(work[b])
            elif kind == 0:
                work[a] = what
            elif kind == 1:
                work[a] = inputs[b][c]
            else:
                outputs[b][c] = work[a]
        return outputs
