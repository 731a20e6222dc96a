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

from __future__ import annotations

import ast
from pathlib import Path

import casadi as ca
import numpy as np
import pytest
from solver_problems import pendulum

from uav_tracking_mpc.mpc import stage_code
from uav_tracking_mpc.mpc.problem import OptimalControlProblem
from uav_tracking_mpc.mpc.stage_code import (
    multiplier_intervals,
    stage_functions,
    stage_module,
    straight_line_code,
)

RANDOM = np.random.default_rng(3)


def interpret(lines: list[str], inputs: list[np.ndarray], outputs: list[np.ndarray]) -> None:
    """Run straight-line code in Python, by the description of its language."""
    two = {
        "add": np.add, "sub": np.subtract, "mul": np.multiply, "div": np.divide, "pow": np.power,
        "lt": np.less, "le": np.less_equal, "eq": np.equal, "ne": np.not_equal, "fmin": np.fmin,
        "fmax": np.fmax, "atan2": np.arctan2,
        "choose": lambda condition, value: value if condition else 0.0,
    }  # fmt: skip
    one = {"neg": np.negative, "fabs": np.abs, "atan": np.arctan, "asin": np.arcsin}
    values: dict[str, float] = {}

    def value(word: str) -> float:
        return values[word] if word in values else float(word)

    for line in lines:
        words = line.split()
        if words[0] == "store":
            outputs[int(words[1])].flat[int(words[2])] = value(words[3])
            continue
        target, _, operation, *operands = words
        if operation == "load":
            values[target] = float(inputs[int(operands[0])].flat[int(operands[1])])
        elif operation in two:
            values[target] = float(two[operation](*(value(word) for word in operands)))
        else:
            function = one.get(operation) or getattr(np, operation)
            values[target] = float(function(value(operands[0])))


def test_code_computes_what_casadi_computes():
    x = ca.SX.sym("x", 3)
    expression = ca.vertcat(
        ca.sin(x[0]) * ca.exp(x[1]) / (1 + x[2] ** 2),
        ca.if_else(x[0] > x[1], ca.sqrt(ca.fabs(x[2])), ca.atan2(x[0], x[1])),
        ca.fmax(x[0], x[2]) - ca.sign(x[1]) + 2 * x[0] - ca.tanh(x[1]) ** 3,
        ca.logic_and(x[0] > 0, ca.logic_not(x[1] > 0)),
    )
    function = ca.Function("f", [x], [expression])
    lines = straight_line_code(function)
    for _ in range(20):
        point = RANDOM.normal(size=3)
        out = np.zeros(4)
        interpret(lines, [point], [out])
        np.testing.assert_allclose(out, np.array(function(point)).ravel(), rtol=1e-13)


def test_an_operation_without_translation_is_named():
    x = ca.SX.sym("x")
    with pytest.raises(NotImplementedError, match="operation"):
        straight_line_code(ca.Function("f", [x], [ca.remainder(x, 2.0)]))


def _lagrangian(problem: OptimalControlProblem, w: np.ndarray, p, costate, m) -> float:
    nx, na = problem.nx, problem.na
    h = ca.vertcat(*(c.expression for c in problem.stage_inequalities))
    symbols = [problem.state, problem.decision, problem.inputs, problem.parameter]
    values = ca.Function("v", symbols, [problem.next_state, problem.stage_cost, h])
    x, a, u = w[:nx], w[nx : nx + na], w[nx + na :]
    f, cost, constraints = (np.array(part).ravel() for part in values(x, a, u, p))
    return float(cost[0] + costate @ np.concatenate([f, a]) + m @ constraints)


def test_stage_derivatives_agree_with_finite_differences():
    problem = pendulum()
    ns, nw, nh = 3, 4, 3
    w, p, costate, m = RANDOM.normal(size=nw), [0.2], RANDOM.normal(size=ns), RANDOM.random(nh)
    function = stage_functions(problem)["stage_quadratic"]
    q_packed, q, gradient = (
        np.array(part).ravel()
        for part in function(
            w[:2], w[3:], w[2:3], p, costate, 1.0, m, np.zeros(nh), np.zeros(ns * ns), costate
        )
    )
    hessian = q_packed.reshape(nw, nw)

    def lagrangian(point: np.ndarray) -> float:
        return _lagrangian(problem, point, p, costate, m)

    unit, width = np.eye(nw), 1e-4
    for i in range(nw):
        slope = (lagrangian(w + width * unit[i]) - lagrangian(w - width * unit[i])) / (2 * width)
        assert gradient[i] == pytest.approx(slope, abs=1e-6)
        for j in range(i, nw):
            corner = [
                s * t * lagrangian(w + width * (s * unit[i] + t * unit[j]))
                for s in (1, -1)
                for t in (1, -1)
            ]
            assert hessian[i, j] == pytest.approx(sum(corner) / (4 * width**2), abs=1e-5)
    np.testing.assert_allclose(q, gradient)  # v = lambda


def test_value_function_and_constraints_enter_as_in_the_recursion():
    problem = pendulum()
    ns, nw, nh = 3, 4, 3
    w, p, costate = RANDOM.normal(size=nw), [0.0], RANDOM.normal(size=ns)
    half = RANDOM.normal(size=(ns, ns))
    value, slope, d = half @ half.T, RANDOM.normal(size=ns), RANDOM.random(nh)
    function = stage_functions(problem)["stage_quadratic"]

    def call(d, value, slope):
        packed, q, _ = function(
            w[:2], w[3:], w[2:3], p, costate, 1.0, np.zeros(nh), d, np.triu(value).ravel(), slope
        )
        return np.array(packed).ravel().reshape(nw, nw), np.array(q).ravel()

    following = ca.vertcat(problem.next_state, problem.decision)
    h = ca.vertcat(*(c.expression for c in problem.stage_inequalities))
    symbols = ca.vertcat(problem.state, problem.decision, problem.inputs)
    jacobians = ca.Function(
        "F",
        [symbols, problem.parameter],
        [ca.jacobian(following, symbols), ca.jacobian(h, symbols)],
    )
    f_w, h_w = (np.array(part) for part in jacobians(w, p))
    plain, plain_q = call(np.zeros(nh), np.zeros((ns, ns)), costate)
    full, full_q = call(d, value, slope)
    expected = h_w.T @ np.diag(d) @ h_w + f_w.T @ value @ f_w
    np.testing.assert_allclose(full - plain, np.triu(expected), atol=1e-12)
    np.testing.assert_allclose(full_q - plain_q, f_w.T @ (slope - costate), atol=1e-12)


def test_multiplier_intervals_say_what_kind_a_constraint_is():
    stage, terminal = multiplier_intervals(pendulum(speed_penalty=7.0))
    np.testing.assert_array_equal(stage, [[0, 0, 0], [7, 7, np.inf]])
    np.testing.assert_array_equal(terminal, [[-np.inf, -np.inf, 0], [np.inf, np.inf, np.inf]])


def test_the_stage_that_the_package_keeps_is_generated():
    """That of x+ = x + u, by which the method is read and type-checked."""
    x, u = ca.SX.sym("x"), ca.SX.sym("u")
    problem = OptimalControlProblem(
        state=x,
        inputs=u,
        next_state=x + u,
        stage_cost=x**2 + u**2,
        terminal_cost=2 * x**2,
        horizon=5,
        step=1.0,
        input_lower=np.array([-1.0]),
        input_upper=np.array([1.0]),
    )
    kept = (Path(stage_code.__file__).parent / "newton" / "stage.py").read_text()
    without_title = [ast.dump(node) for node in ast.parse(kept).body[1:]]
    assert without_title == [ast.dump(node) for node in ast.parse(stage_module(problem)).body[1:]]
