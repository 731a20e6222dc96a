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

"""A solver of acados behind two pipes, run by an interpreter that has acados_template.

It needs nothing of this package: numpy, casadi and acados_template of that interpreter, and a C
compiler. The first line that it reads is the problem, every further one a solve; every line that it
writes answers one. Lines hold JSON. See ``benchmark.py`` beside it.
"""

import ctypes
import importlib
import importlib.util
import json
import os
import sys
import tempfile
import time
from typing import Any

UNBOUNDED = 1e9  # -, code for a bound that there is none of
TOLERANCE = 1e-6  # -, tolerance of acados's residuals
ITERATION_LIMIT = 200  # of SQP


def find_acados() -> None:
    """Make acados_template and its libraries loadable, also where acados came as one wheel."""
    if importlib.util.find_spec("acados_template") is None:
        acados: Any = importlib.import_module("acados")
        os.environ.setdefault("ACADOS_SOURCE_DIR", acados.DIR)
        os.environ.setdefault("ACADOS_PYTHON_INTERFACE_PATH", acados.TEMPLATE_DIR)
        sys.path.append(os.path.dirname(acados.__file__))
    folder = os.path.join(os.environ.get("ACADOS_SOURCE_DIR", ""), "lib")
    for name in ("libblasfeo.so", "libhpipm.so", "libqpOASES_e.so.3.1", "libqpOASES_e.so"):
        if os.path.isfile(os.path.join(folder, name)):  # libacados looks for them by name
            ctypes.CDLL(os.path.join(folder, name), mode=ctypes.RTLD_GLOBAL)


def rebuilt(function: dict[str, Any], arguments: tuple[Any, ...]) -> list[Any]:
    """Results of a function that came as a list of operations, whatever the version of CasADi.

    Args:
        function: ``operations`` of [name, outputs, inputs, value], and ``sizes`` of the results.
        arguments: Columns of symbols.
    """
    import casadi as ca

    work: dict[int, Any] = {}
    results: list[list[Any]] = [[0.0] * size for size in function["sizes"]]
    for name, outputs, inputs, value in function["operations"]:
        if name == "OP_CONST":
            work[outputs[0]] = ca.SX(value)
        elif name == "OP_INPUT":
            work[outputs[0]] = arguments[inputs[0]][inputs[1]]
        elif name == "OP_OUTPUT":
            results[outputs[0]][outputs[1]] = work[inputs[0]]
        elif len(inputs) == 1:
            work[outputs[0]] = ca.SX.unary(getattr(ca, name), work[inputs[0]])
        else:
            operands = [work[index] for index in inputs]
            work[outputs[0]] = ca.SX.binary(getattr(ca, name), *operands)
    return [ca.vertcat(*parts) if parts else ca.SX.zeros(0, 1) for parts in results]


def formulation(told: dict[str, Any], folder: str) -> Any:
    """The problem as acados takes it: constant decisions are states, soft inequalities have slacks.

    Args:
        told: The problem.
        folder: Gets the generated code.
    """
    import casadi as ca
    import numpy as np
    from acados_template import AcadosOcp

    sizes, n = told["sizes"], told["horizon"]
    x, u, p, a = (ca.SX.sym(name, sizes[name]) for name in ("x", "u", "p", "a"))
    following, cost, hard, soft = rebuilt(told["stage"], (x, u, p, a))
    end_cost, end_equal, end_hard, end_soft = rebuilt(told["end"], (x, u, p, a))
    ocp = AcadosOcp()
    model, constraints, costs, options = ocp.model, ocp.constraints, ocp.cost, ocp.solver_options
    model.name = told["name"]
    model.x, model.u, model.p = ca.vertcat(x, a), u, p
    model.disc_dyn_expr = ca.vertcat(following, a)
    costs.cost_type = costs.cost_type_e = "EXTERNAL"
    model.cost_expr_ext_cost, model.cost_expr_ext_cost_e = cost, end_cost
    constraints.lbu, constraints.ubu = np.array(told["input_lower"]), np.array(told["input_upper"])
    constraints.idxbu = np.arange(sizes["u"])
    lower = np.concatenate([np.zeros(sizes["x"]), told["decision_lower"]])
    upper = np.concatenate([np.zeros(sizes["x"]), told["decision_upper"]])
    constraints.lbx_0, constraints.ubx_0 = lower, upper
    constraints.idxbx_0 = np.arange(len(lower))
    constraints.idxbxe_0 = np.arange(sizes["x"])

    def limit(where: str, hard: Any, soft: Any, equal: Any, penalties: list[float]) -> None:
        """Inequalities, slacks and their penalties, of "", "_0" or "_e"."""
        count = hard.numel() + soft.numel()
        if count + equal.numel() == 0:
            return
        setattr(model, f"con_h_expr{where}", ca.vertcat(hard, soft, equal))
        least = np.concatenate([np.full(count, -UNBOUNDED), np.zeros(equal.numel())])
        setattr(constraints, f"lh{where}", least)
        setattr(constraints, f"uh{where}", np.zeros(len(least)))
        if soft.numel():
            setattr(constraints, f"idxsh{where}", np.arange(hard.numel(), count))
            for name in ("zl", "zu"):
                setattr(costs, f"{name}{where}", np.array(penalties))
            for name in ("Zl", "Zu"):
                setattr(costs, f"{name}{where}", np.zeros(len(penalties)))

    nothing = ca.SX.zeros(0, 1)
    limit("", hard, soft, nothing, told["stage_penalties"])
    if hasattr(model, "con_h_expr_0"):  # later versions treat stage 0 on its own
        limit("_0", hard, soft, nothing, told["stage_penalties"])
    limit("_e", end_hard, end_soft, end_equal, told["end_penalties"])
    ocp.parameter_values = np.zeros(sizes["p"])
    if hasattr(options, "N_horizon"):
        options.N_horizon = n
    else:
        ocp.dims.N = n
    options.tf = float(n)  # intervals of 1: acados multiplies the costs by their length
    options.integrator_type, options.hessian_approx = "DISCRETE", "EXACT"
    options.qp_solver, options.qp_solver_cond_N = "PARTIAL_CONDENSING_HPIPM", min(n, 5)
    options.qp_solver_iter_max, options.qp_solver_warm_start = 200, 1
    options.regularize_method = "MIRROR"
    options.nlp_solver_type = "SQP_RTI" if told["kind"] == "rti" else "SQP"
    options.nlp_solver_max_iter = ITERATION_LIMIT
    if told["kind"] != "rti":
        options.globalization = "MERIT_BACKTRACKING"
    for name in ("stat", "eq", "ineq", "comp"):
        setattr(options, f"nlp_solver_tol_{name}", TOLERANCE)
    options.ext_fun_compile_flags = "-O2 -march=native"
    options.print_level = 0
    ocp.code_export_directory = os.path.join(folder, "code")
    return ocp


class Solves:
    """The compiled solver, and the solves that it is asked for.

    Args:
        told: The problem.
        folder: Gets the generated code.
    """

    def __init__(self, told: dict[str, Any], folder: str) -> None:
        from acados_template import AcadosOcpSolver

        self.n, self.nx = told["horizon"], told["sizes"]["x"]
        self.real_time = told["kind"] == "rti"
        self.parameters = told["sizes"]["p"] > 0
        self.decision_bounds = told["decision_lower"], told["decision_upper"]
        ocp = formulation(told, folder)
        self.solver = AcadosOcpSolver(ocp, json_file=os.path.join(folder, "ocp.json"))

    def solve(self, asked: dict[str, Any]) -> dict[str, Any]:
        """Start from the plan that is given, with the multipliers of the last solve moved on.

        Args:
            asked: State, parameters, plan, and whether it is a cold start.
        """
        import numpy as np

        solver, n = self.solver, self.n
        state, decision = np.array(asked["state"]), np.array(asked["decision"])
        if asked["cold"]:
            solver.reset()
        else:
            for field, first in (("pi", 0), ("lam", 1)):
                for stage in range(first, n - 1):
                    solver.set(stage, field, solver.get(stage + 1, field))
        lower, upper = (np.concatenate([state, bound]) for bound in self.decision_bounds)
        solver.set(0, "lbx", lower)
        solver.set(0, "ubx", upper)
        for stage in range(n + 1):
            solver.set(stage, "x", np.concatenate([asked["states"][stage], decision]))
            if stage < n:
                solver.set(stage, "u", np.array(asked["inputs"][stage]))
            if self.parameters:
                solver.set(stage, "p", np.array(asked["parameters"][stage]))
        begin = time.perf_counter()
        status = solver.solve()
        duration = time.perf_counter() - begin
        iterations = int(np.ravel(solver.get_stats("sqp_iter"))[0])
        if self.real_time and asked["cold"]:  # its scheme begins at a plan that is optimal
            change = np.inf
            while change > TOLERANCE and iterations < ITERATION_LIMIT and status == 0:
                before = [solver.get(stage, "u") for stage in range(n)]
                status, iterations = solver.solve(), iterations + 1
                after = [solver.get(stage, "u") for stage in range(n)]
                change = np.abs(np.subtract(after, before)).max()
            duration = time.perf_counter() - begin
            status = status if change <= TOLERANCE else 2
        states = np.array([solver.get(stage, "x") for stage in range(n + 1)])
        return {
            "status": int(status),
            "time": duration,
            "iterations": iterations,
            "states": states[:, : self.nx].tolist(),
            "decision": states[0, self.nx :].tolist(),
            "inputs": [solver.get(stage, "u").tolist() for stage in range(n)],
        }


def main() -> None:
    """Answer until the pipe is closed."""
    answers = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)  # whatever compilers and libraries print goes to stderr

    def say(content: dict[str, Any]) -> None:
        answers.write(json.dumps(content) + "\n")
        answers.flush()

    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)  # acados writes beside it
        try:
            find_acados()
            solves = Solves(json.loads(sys.stdin.readline()), folder)
        except Exception as error:  # whatever is missing there
            words = f"{type(error).__name__}: {error}"
            say({"error": " ".join(words.split())[:300]})
            return
        say({"ready": True})
        for line in sys.stdin:
            say(solves.solve(json.loads(line)))


if __name__ == "__main__":
    main()
