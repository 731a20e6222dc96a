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

"""CasADi functions: built by one thread at a time, evaluated without conversions, walked through.

CasADi gives the interpreter's lock away while it works, and two threads that build expressions at
the same time have been seen to end the process. Who builds expressions where another thread may do
so holds this lock; evaluating a function needs none. Here are also what makes a function of rates
one of steps, forward Euler (10) and Runge-Kutta 4, and its linearisation (12).
"""

from __future__ import annotations

import functools
import threading
from collections.abc import Callable, Sequence
from typing import Any, ParamSpec, TypeVar

import casadi as ca
import numpy as np
from numpy.typing import NDArray

P = ParamSpec("P")
T = TypeVar("T")
LOCK = threading.RLock()


def one_at_a_time(function: Callable[P, T]) -> Callable[P, T]:
    """The function, which waits until no other thread does symbolic work.

    Args:
        function: That builds expressions.
    """

    @functools.wraps(function)
    def alone(*arguments: P.args, **named: P.kwargs) -> T:
        with LOCK:
            return function(*arguments, **named)

    return alone


class BufferedFunction:
    """A function on arrays of its own: fill ``arguments``, call :meth:`evaluate`, read ``results``.

    A call of the function converts what it is given, which takes a hundred times as long as
    evaluating a small function.

    Args:
        function: Of dense arguments and results.
        arguments: Arrays to read from, C-contiguous, of any shape with as many numbers as the
            argument of the function, which are taken by columns; None, or none at all, for an array
            of its own.

    Attributes:
        function: As above.
        arguments: Flat arrays of their own, or those given.
        results: One flat array for each result, by columns, overwritten each time.
    """

    def __init__(
        self, function: ca.Function, arguments: Sequence[NDArray[np.float64] | None] = ()
    ) -> None:
        given = [*arguments, *[None] * (function.n_in() - len(arguments))]
        self.arguments = [
            np.zeros(function.nnz_in(k)) if array is None else array
            for k, array in enumerate(given)
        ]
        self.results = [np.zeros(function.nnz_out(k)) for k in range(function.n_out())]
        self.function = function
        self._buffer, self._evaluate = function.buffer()
        for k, array in enumerate(self.arguments):
            self._buffer.set_arg(k, memoryview(array.reshape(-1)))  # type: ignore
        for k, array in enumerate(self.results):
            self._buffer.set_res(k, memoryview(array))  # type: ignore

    def evaluate(self) -> None:
        """Write the results of the arguments as they are."""
        self._evaluate()


def walk(
    function: ca.Function,
    load: Callable[[int, int], T],
    constant: Callable[[float], T],
    apply: Callable[..., T],
    store: Callable[[int, int, T], object],
) -> None:
    """Go through the instructions of a function of SX type, with values of any kind.

    Args:
        function: Whose instructions.
        load: The value of an input, by its number and that of its nonzero.
        constant: The value of a number.
        apply: The value of an operation, from its code (``casadi.OP_...``) and its operands.
        store: Called with the number of an output, that of its nonzero, and the value.
    """
    work: dict[int, T] = {}
    for k in range(function.n_instructions()):
        code = function.instruction_id(k)
        ins, outs = function.instruction_input(k), function.instruction_output(k)
        if code == ca.OP_OUTPUT:
            store(outs[0], outs[1], work[ins[0]])
        elif code == ca.OP_INPUT:
            work[outs[0]] = load(ins[0], ins[1])
        elif code == ca.OP_CONST:
            work[outs[0]] = constant(function.instruction_constant(k))
        elif code == ca.OP_ASSIGN:
            work[outs[0]] = work[ins[0]]
        else:
            work[outs[0]] = apply(code, *(work[i] for i in ins))


def evaluate(
    function: ca.Function,
    inputs: Sequence[Sequence[T]],
    constant: Callable[[float], T],
    apply: Callable[..., T],
) -> list[list[T]]:
    """Nonzeros of each output of a function of SX type, from those of its ``inputs``.

    Args:
        function: What is evaluated.
        inputs: Of any kind that ``apply`` takes.
        constant: See :func:`walk`.
        apply: See :func:`walk`.
    """
    results: list[list[T]] = [
        [constant(0.0)] * function.nnz_out(i) for i in range(function.n_out())
    ]
    walk(
        function,
        lambda number, nonzero: inputs[number][nonzero],
        constant,
        apply,
        lambda number, nonzero, value: results[number].__setitem__(nonzero, value),
    )
    return results


def euler(rates: ca.Function, state: ca.SX, inputs: ca.SX, step: Any) -> ca.SX:
    """One forward Euler step, as in (10).

    Args:
        rates: CasADi function (state, inputs) -> time derivative of the state.
        state: Where the step begins, shape (nx, 1).
        inputs: Held over the step, shape (nu, 1).
        step: T_s in [s], a number or a symbol.
    """
    return state + step * rates(state, inputs)


def runge_kutta4(rates: ca.Function, state: ca.SX, inputs: ca.SX, step: Any) -> ca.SX:
    """One classical Runge-Kutta step with the inputs held.

    Args:
        rates: CasADi function (state, inputs) -> time derivative of the state.
        state: Where the step begins, shape (nx, 1).
        inputs: Held over the step, shape (nu, 1).
        step: T_s in [s], a number or a symbol.
    """
    k1 = rates(state, inputs)
    k2 = rates(state + 0.5 * step * k1, inputs)
    k3 = rates(state + 0.5 * step * k2, inputs)
    k4 = rates(state + step * k3, inputs)
    return state + step / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)


SCHEMES: dict[str, Callable[[ca.Function, ca.SX, ca.SX, Any], ca.SX]] = {
    "euler": euler,
    "rk4": runge_kutta4,
}


def linearise(
    dynamics: ca.Function, state: NDArray | None = None, inputs: NDArray | None = None
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """A and B of (12): Jacobians of f by automatic differentiation.

    Args:
        dynamics: CasADi function (x, u) -> x+.
        state: Where to linearise, shape (nx,); the origin by default.
        inputs: Likewise, shape (nu,).

    Returns:
        A, shape (nx, nx), and B, shape (nx, nu).
    """
    x, u = ca.SX.sym("x", dynamics.size1_in(0)), ca.SX.sym("u", dynamics.size1_in(1))
    following = dynamics(x, u)
    jacobians = ca.Function("AB", [x, u], [ca.jacobian(following, x), ca.jacobian(following, u)])
    a, b = jacobians(0 if state is None else state, 0 if inputs is None else inputs)
    return np.array(a), np.array(b)
