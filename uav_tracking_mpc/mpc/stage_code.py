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

r"""The equations of a problem and their derivatives as straight-line code, made from its symbols.

Five programs are all that the Newton method needs. With s = (x, a) the state extended by the
constant decisions, w = (s, u), F = d(x+, a)/dw, and the Lagrangian of a stage

.. math::

    L(w, \lambda, m) = l(w) + \lambda^T f(w) + m^T h(w)

``stage_values``
    f, l, h
``stage_quadratic``
    gradient L_w, and the quadratic model that the Riccati recursion minimises,
    Q = L_ww + h_w^T D h_w + F^T V F,  q = L_w + F^T (v - lambda)
``terminal_values``
    V_f and the terminal constraints e
``terminal_quadratic``
    V = V_f,ss + (m^T e)_ss + e_s^T D e_s,  v = (V_f + m^T e)_s
``continuation``
    input after the last stage

F^T V F is formed symbolically as well, so the zeros and constants of F cost nothing at run time.
Each function is listed operation by operation in the form of
:mod:`uav_tracking_mpc.mpc.newton.compiling`.
"""

from __future__ import annotations

from collections.abc import Iterable

import casadi as ca
import numpy as np

from uav_tracking_mpc.mpc.problem import Inequality, OptimalControlProblem
from uav_tracking_mpc.symbolic.functions import walk

OPERATIONS = {
    ca.OP_ADD: "add", ca.OP_SUB: "sub", ca.OP_MUL: "mul", ca.OP_DIV: "div", ca.OP_POW: "pow",
    ca.OP_CONSTPOW: "pow", ca.OP_LT: "lt", ca.OP_LE: "le", ca.OP_EQ: "eq", ca.OP_NE: "ne",
    ca.OP_AND: "mul", ca.OP_FMIN: "fmin", ca.OP_FMAX: "fmax", ca.OP_ATAN2: "atan2",
    ca.OP_COPYSIGN: "copysign", ca.OP_IF_ELSE_ZERO: "choose", ca.OP_HYPOT: "hypot",
    ca.OP_FMOD: "fmod", ca.OP_OR: "fmax",
    ca.OP_NEG: "neg", ca.OP_SQRT: "sqrt", ca.OP_SIN: "sin", ca.OP_COS: "cos", ca.OP_TAN: "tan",
    ca.OP_ASIN: "asin", ca.OP_ACOS: "acos", ca.OP_ATAN: "atan", ca.OP_EXP: "exp",
    ca.OP_LOG: "log", ca.OP_SINH: "sinh", ca.OP_COSH: "cosh", ca.OP_TANH: "tanh",
    ca.OP_ASINH: "asinh", ca.OP_ACOSH: "acosh", ca.OP_ATANH: "atanh", ca.OP_FABS: "fabs",
    ca.OP_FLOOR: "floor", ca.OP_CEIL: "ceil", ca.OP_ERF: "erf", ca.OP_LOG1P: "log1p",
    ca.OP_EXPM1: "expm1",
}  # fmt: skip


def stage_module(problem: OptimalControlProblem) -> str:
    """Source of ``stage.py``: sizes of a problem and the five programs.

    Args:
        problem: What is solved.

    Raises:
        NotImplementedError: An expression uses an operation that has no translation.
    """
    stage, terminal = multiplier_intervals(problem)
    lines = [
        '"""Sizes and equations of one problem; written by ``mpc/stage_code.py``."""',
        "",
        "from .compiling import straight_line",
        "",
        f"N = {problem.horizon}  # stages",
        f"NX = {problem.nx}  # states x",
        f"NU = {problem.nu}  # inputs u",
        f"NA = {problem.na}  # decisions a, constant over the horizon",
        f"NP = {problem.np}  # parameters p of a stage",
        f"NH = {stage.shape[1]}  # stage inequalities h",
        f"NE = {terminal.shape[1]}  # terminal constraints e",
        "NS = NX + NA  # extended state s = (x, a)",
        "NW = NS + NU  # w = (s, u)",
    ]
    for name, function in stage_functions(problem).items():
        inputs = ", ".join(function.name_in())
        outputs = ", ".join(function.name_out())
        lines += ["", f"# ({inputs}) -> ({outputs})", f'{name} = straight_line("""']
        lines += [*straight_line_code(function), '""")']
    return "\n".join(lines) + "\n"


def stage_functions(problem: OptimalControlProblem) -> dict[str, ca.Function]:
    """The five functions of the module's docstring, as CasADi functions, of a ``problem``."""
    x, u, a, p = problem.state, problem.inputs, problem.decision, problem.parameter
    s = ca.vertcat(x, a)
    w = ca.vertcat(s, u)
    h = _column(h.expression for h in problem.stage_inequalities)
    e = ca.vertcat(
        problem.terminal_equality, _column(h.expression for h in problem.terminal_inequalities)
    )
    ns = s.numel()
    costate, following = ca.SX.sym("lambda", ns), ca.vertcat(problem.next_state, a)
    curvature = ca.SX.sym("curvature")  # 1: exact Hessian; 0: Gauss-Newton in the dynamics
    m, d = ca.SX.sym("m", h.numel()), ca.SX.sym("d", h.numel())
    # Read by its upper triangle, row by row: the lower one to CasADi, which goes by columns.
    value, value_gradient = ca.SX.sym("V", ns, ns), ca.SX.sym("v", ns)
    value_symmetric = ca.tril2symm(ca.tril(value))

    lagrangian = problem.stage_cost + ca.dot(costate, following) + ca.dot(m, h)
    curved = problem.stage_cost + curvature * ca.dot(costate, following) + ca.dot(m, h)
    gradient = ca.gradient(lagrangian, w)
    dynamics, constraint = ca.jacobian(following, w), ca.jacobian(h, w)
    quadratic = (
        ca.hessian(curved, w)[0]
        + constraint.T @ ca.diag(d) @ constraint
        + dynamics.T @ value_symmetric @ dynamics
    )
    linear = gradient + dynamics.T @ (value_gradient - costate)

    m_end, d_end = ca.SX.sym("m", e.numel()), ca.SX.sym("d", e.numel())
    end = problem.terminal_cost + ca.dot(m_end, e)
    end_constraint = ca.jacobian(e, s)
    end_quadratic = ca.hessian(end, s)[0] + end_constraint.T @ ca.diag(d_end) @ end_constraint
    at_stage, at_end = {"x": x, "u": u, "a": a, "p": p}, {"x": x, "a": a, "p": p}
    model = {"costate": costate, "curvature": curvature, "m": m, "d": d}
    after = problem.inputs if problem.continuation is None else problem.continuation
    dense = ca.densify  # but for the matrices: of those only the upper triangle is written
    programs = {
        "stage_values": (
            at_stage,
            {"f": dense(problem.next_state), "l": dense(problem.stage_cost), "h": dense(h)},
        ),
        "stage_quadratic": (
            {**at_stage, **model, "V": ca.vec(value), "v": value_gradient},
            {"Q": _upper(quadratic), "q": dense(linear), "gradient": dense(gradient)},
        ),
        "terminal_values": (at_end, {"l": dense(problem.terminal_cost), "e": dense(e)}),
        "terminal_quadratic": (
            {**at_end, "m": m_end, "d": d_end},
            {"V": _upper(end_quadratic), "v": dense(ca.gradient(end, s))},
        ),
        "continuation": (at_stage, {"u_end": dense(after)}),
    }
    return {
        name: ca.Function(
            name, [*inputs.values()], ca.cse([*outputs.values()]), [*inputs], [*outputs]
        )
        for name, (inputs, outputs) in programs.items()
    }


def straight_line_code(function: ca.Function) -> list[str]:
    """Lines of a program that evaluates a CasADi SX ``function``."""
    elements = [function.sparsity_out(k).find() for k in range(function.n_out())]
    lines: list[str] = []

    def assigned(operation: str) -> str:
        lines.append(f"t{len(lines)} = {operation}")
        return f"t{len(lines) - 1}"

    def applied(code: int, x: str, *others: str) -> str:
        composed = {
            ca.OP_SQ: f"mul {x} {x}",
            ca.OP_TWICE: f"mul 2.0 {x}",
            ca.OP_INV: f"div 1.0 {x}",
            ca.OP_NOT: f"eq {x} 0.0",
        }
        if code == ca.OP_SIGN:
            positive, negative = assigned(f"lt 0.0 {x}"), assigned(f"lt {x} 0.0")
            return assigned(f"sub {positive} {negative}")
        if code in composed:
            return assigned(composed[code])
        if code not in OPERATIONS:
            raise NotImplementedError(f"operation {code} of CasADi has no straight-line form")
        return assigned(" ".join([OPERATIONS[code], x, *others]))

    walk(
        function,
        lambda number, nonzero: assigned(f"load {number} {nonzero}"),
        lambda value: repr(float(value)),
        applied,
        lambda k, nonzero, value: lines.append(f"store {k} {elements[k][nonzero]} {value}"),
    )
    return lines


def multiplier_intervals(problem: OptimalControlProblem) -> tuple[np.ndarray, np.ndarray]:
    """Where the multipliers of h and of e of a ``problem`` may lie, shapes (2, nh) and (2, ne).

    [0, inf) for a hard inequality, [0, penalty] for a soft one; (-inf, inf) for an equality, and e
    begins with those.
    """
    free = np.full((2, problem.terminal_equality.numel()), np.inf) * [[-1.0], [1.0]]
    ends = np.hstack([free, _intervals(problem.terminal_inequalities)])
    return _intervals(problem.stage_inequalities), ends


def _intervals(inequalities: tuple[Inequality, ...]) -> np.ndarray:
    upper = [
        np.inf if h.penalty is None else h.penalty
        for h in inequalities
        for _ in range(h.expression.numel())
    ]
    return np.array([np.zeros(len(upper)), upper])


def _column(expressions: Iterable[ca.SX]) -> ca.SX:
    return ca.vertcat(ca.SX.zeros(0, 1), *(ca.vec(ca.densify(part)) for part in expressions))


def _upper(matrix: ca.SX) -> ca.SX:
    """Row-major upper triangle of a symmetric matrix, in place within the full square."""
    return ca.vec(ca.tril(ca.densify(matrix)))
