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

"""Columns and matrices of intervals, and CasADi functions on them: the checker's linear algebra."""

from __future__ import annotations

import operator
from collections.abc import Callable
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.terminal.interval import Interval

Column = list[Interval]
Matrix = list[list[Interval]]


_OPERATIONS: dict[int, Callable[..., Interval]] = {
    ca.OP_ASSIGN: lambda a: a,
    ca.OP_ADD: operator.add,
    ca.OP_SUB: operator.sub,
    ca.OP_MUL: operator.mul,
    ca.OP_DIV: operator.truediv,
    ca.OP_NEG: operator.neg,
    ca.OP_SQ: Interval.square,
    ca.OP_TWICE: lambda a: a * 2.0,
    ca.OP_INV: Interval.inverse,
    ca.OP_SQRT: Interval.sqrt,
    ca.OP_SIN: Interval.sin,
    ca.OP_COS: Interval.cos,
}


def evaluate(function: ca.Function, inputs: list[Column]) -> list[Column]:
    """Walk the instructions of a CasADi ``function`` with intervals for its ``inputs``.

    Raises:
        ValueError: An operation that is not known here.
    """
    work: dict[int, Interval] = {}
    outputs: list[Column] = [[Interval(0.0)] * function.nnz_out(i) for i in range(function.n_out())]
    for k in range(function.n_instructions()):
        code = function.instruction_id(k)
        ins, outs = function.instruction_input(k), function.instruction_output(k)
        if code == ca.OP_OUTPUT:
            outputs[outs[0]][outs[1]] = work[ins[0]]
        elif code == ca.OP_INPUT:
            work[outs[0]] = inputs[ins[0]][ins[1]]
        elif code == ca.OP_CONST:
            work[outs[0]] = Interval(function.instruction_constant(k))
        elif code in _OPERATIONS:
            work[outs[0]] = _OPERATIONS[code](*(work[i] for i in ins))
        else:
            raise ValueError(f"operation {code} of the model is not known here")
    return outputs


def unpack(function: ca.Function, index: int, entries: Column) -> Matrix:
    """Dense matrix from the nonzeros of one output of a CasADi function; zeros are exact.

    Args:
        function: The function.
        index: Of the output.
        entries: Its nonzeros.
    """
    sparsity = function.sparsity_out(index)
    full = [[Interval(0.0) for _ in range(sparsity.size2())] for _ in range(sparsity.size1())]
    rows, columns = sparsity.get_triplet()
    for i, j, entry in zip(rows, columns, entries, strict=True):
        full[i][j] = entry
    return full


def definite(matrix: Matrix) -> NDArray[np.bool_]:
    """Where every symmetric matrix in an interval ``matrix`` is positive definite (LDL').

    Returns:
        Of the shape of the matrix's intervals.
    """
    rows = [list(row) for row in matrix]
    good: Any = np.asarray(True)
    with np.errstate(invalid="ignore", over="ignore"):
        for k in range(len(rows)):
            pivot = rows[k][k]
            good = good & (pivot.lower > 0.0)
            for i in range(k + 1, len(rows)):
                factor = rows[i][k] / pivot
                for j in range(k + 1, i + 1):
                    rows[i][j] = rows[i][j] - factor * rows[j][k]
    return np.asarray(good)


def inverse_of(p: NDArray[np.float64]) -> Matrix:
    """Enclosure of P^-1: W near it and R = I - PW give |P^-1 - W| <= |W| |R| / (1 - |R|).

    Args:
        p: P, shape (n, n).
    """
    indices = range(len(p))
    w = np.linalg.inv(p)
    w = 0.5 * (w + w.T)
    both = product(constant(p), constant(w))
    squares = total(
        (Interval(float(i == j)) - both[i][j]).square() for i in indices for j in indices
    )
    residual = Interval(0.0, squares.upper).sqrt()
    if not residual.upper < 1e-3:
        raise ValueError("P cannot be inverted")
    size = total(Interval(v).square() for v in w.ravel()).sqrt()
    radius = (size * residual / (Interval(1.0) - residual)).upper
    return [[Interval(w[i, j]) + Interval(-radius, radius) for j in indices] for i in indices]


def reach(row: NDArray[np.float64], inverse: Matrix, level: float) -> Interval:
    """Largest c'x over x'Px <= level: sqrt(level c'P^-1 c).

    Args:
        row: c, shape (n,).
        inverse: Enclosure of P^-1.
        level: varrho [-].
    """
    return (quadratic(inverse, [Interval(v) for v in row]) * level).sqrt()


def constant(values: NDArray[np.float64]) -> Matrix:
    """Matrix of the numbers ``values``, shape (n, m), taken as exact."""
    return [[Interval(entry) for entry in row] for row in values]


def columns(values: NDArray[np.float64]) -> Column:
    """Columns of ``values``, shape (m, n): n intervals of m numbers each."""
    return [Interval(values[:, i]) for i in range(values.shape[1])]


def transpose(matrix: Matrix) -> Matrix:
    """The ``matrix`` transposed."""
    return [list(row) for row in zip(*matrix, strict=True)]


def product(left: Matrix, right: Matrix) -> Matrix:
    """Product of the matrices ``left`` and ``right``."""
    columns = transpose(right)
    return [
        [total(a * b for a, b in zip(row, column, strict=True)) for column in columns]
        for row in left
    ]


def times(matrix: Matrix, column: Column) -> Column:
    """Product of ``matrix`` and ``column``."""
    return [total(a * b for a, b in zip(row, column, strict=True)) for row in matrix]


def quadratic(matrix: Matrix, column: Column) -> Interval:
    """Quadratic form x'Mx of the ``matrix`` M at the ``column`` x."""
    return total(a * b for a, b in zip(column, times(matrix, column), strict=True))


def total(terms: Any) -> Interval:
    """Sum of the intervals ``terms``."""
    total = Interval(0.0)
    for term in terms:
        total = total + term
    return total
