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

"""Benchmark with acados beside the other solvers.

With all options of ``uav_tracking benchmark``::

    python3 examples/acados/benchmark.py --acados PYTHON

acados needs a C compiler, and its wheels
pin a version of CasADi that is not ours; so the solver is built and run by an interpreter that has
acados_template, asked over pipes (``acados_program.py``). The equations travel as a list of
operations, plans as JSON. Only the call of acados itself is timed, over there: no pipe, no Python
around it.
"""

from __future__ import annotations

import contextlib
import importlib.util
import json
import select
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike, NDArray

from uav_tracking_mpc.cli import benchmark
from uav_tracking_mpc.cli.program import CommandParser, explained
from uav_tracking_mpc.mpc.casadi_solver import (
    NonlinearProgram,
    PlanGuess,
    hard_and_soft,
    plan_guesses,
)
from uav_tracking_mpc.mpc.problem import OptimalControlProblem
from uav_tracking_mpc.mpc.solver import Guess, Solution, Status, solve_data
from uav_tracking_mpc.studies.benchmark.optimality import OptimalityMeasure

PROGRAM = Path(__file__).with_name("acados_program.py")
KINDS = {"acados_sqp": "sqp", "acados_rti": "rti"}  # to convergence; one iteration a step
BUILD_LIMIT, SOLVE_LIMIT = 600.0, 60.0  # s
OPERATIONS = {getattr(ca, name): name for name in dir(ca) if name.startswith("OP_")}


class PeerError(RuntimeError):
    """The program of a peer does not start, or does not answer; the message says why."""


class AcadosPeer:
    """Solver (see :class:`uav_tracking_mpc.mpc.solver.Solver`) in a program of its own.

    Args:
        problem: What to solve.
        name: One of :data:`KINDS`.
        interpreter: Python that has acados_template.

    Raises:
        PeerError: The interpreter has no acados, or acados cannot be built for the problem.
    """

    timed_inside = True
    time_limit = float("inf")

    def __init__(self, problem: OptimalControlProblem, name: str, interpreter: str) -> None:
        self.name, self.problem, self.lost = name, problem, ""
        self._last: Solution | None = None
        self._measure, self._model = OptimalityMeasure(problem), NonlinearProgram(problem)
        self._errors = tempfile.TemporaryFile("w+")  # noqa: SIM115
        try:
            self._program = subprocess.Popen(
                [interpreter, PROGRAM],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=self._errors,
                text=True,
            )
        except OSError as error:
            raise PeerError(f"{interpreter} cannot be started: {error.strerror}") from error
        try:
            answer = self._asked(_told(problem, KINDS[name]), BUILD_LIMIT)
            if "error" in answer:
                raise PeerError(str(answer["error"]))
        except PeerError:
            self.close()
            raise

    def close(self) -> None:
        """End the program."""
        assert self._program.stdin is not None and self._program.stdout is not None
        with contextlib.suppress(BrokenPipeError):
            self._program.stdin.close()
        try:
            self._program.wait(5.0)
        except subprocess.TimeoutExpired:
            self._program.kill()
            self._program.wait()
        self._program.stdout.close()
        self._errors.close()

    def change(self, problem: OptimalControlProblem) -> None:
        """See :meth:`uav_tracking_mpc.mpc.solver.Solver.change`; the program keeps its bounds.

        Args:
            problem: Of the same expressions; ``parameter_values`` may differ.

        Raises:
            ValueError: A bound or the goal differs.
        """
        for name in (
            "input_lower",
            "input_upper",
            "decision_lower",
            "decision_upper",
            "state_goal",
        ):
            if not np.array_equal(getattr(problem, name), getattr(self.problem, name)):
                raise ValueError(f"{name} differs, must be that of the problem that was built")
        self.problem = problem
        self.reset()

    def reset(self) -> None:
        """Forget the last plan: the next solve starts cold."""
        self._last = None

    def solve(
        self,
        initial_state: ArrayLike,
        parameters: ArrayLike | None = None,
        elapsed: float | None = None,
        guess: Callable[[], Guess | None] | None = None,
    ) -> Solution:
        """Solve P_N(x_0), (16): see :meth:`uav_tracking_mpc.mpc.solver.Solver.solve`.

        Once the program is lost, ``lost`` says why and every solve fails.
        """
        problem = self.problem
        state, p = solve_data(problem, initial_state, parameters)
        cold = elapsed is None or self._last is None
        if self.lost:
            return Solution.without_plan(problem, Status.FAILED, self.lost, 0.0)
        guesses = plan_guesses(
            problem,
            state,
            self._last,
            elapsed,
            guess,
            lambda inputs, decision: self._model.rollout(state, inputs, p, decision),
        )
        try:
            solved = [self._solve_from(begin, state, p, cold) for begin in guesses]
        except PeerError as error:
            self.lost = str(error)
            return Solution.without_plan(problem, Status.FAILED, self.lost, 0.0)
        best = min(solved, key=lambda each: (not each.converged, each.cost))
        self._last = best if best.converged else None
        total = sum(each.solve_time for each in solved)
        return best._replace(solve_time=total)

    def _solve_from(
        self, guess: PlanGuess, state: NDArray[np.float64], p: NDArray[np.float64], cold: bool
    ) -> Solution:
        problem = self.problem
        asked = {
            "state": state.tolist(),
            "parameters": p.tolist(),
            "states": guess.states.tolist(),
            "inputs": guess.inputs.tolist(),
            "decision": np.asarray(guess.decision).tolist(),
            "cold": cold,
        }
        answer = self._asked(asked, SOLVE_LIMIT)
        inputs = np.array(answer["inputs"], dtype=float)
        decision = np.array(answer["decision"], dtype=float)
        if not (np.all(np.isfinite(inputs)) and np.all(np.isfinite(decision))):
            reason, duration = "the plan is not finite", float(answer["time"])
            return Solution.without_plan(problem, Status.FAILED, reason, duration)
        inputs = np.clip(inputs, problem.input_lower, problem.input_upper)
        cost, _, violation = self._measure(state, inputs, decision, p)
        good = answer["status"] == 0
        return Solution(
            status=Status.CONVERGED if good else Status.FAILED,
            message="converged" if good else f"failed: acados ended with {answer['status']}",
            cost=cost,
            iterations=int(answer["iterations"]),
            solve_time=float(answer["time"]),
            states=np.array(answer["states"], dtype=float),
            inputs=inputs,
            decision=decision,
            violation=violation,
        )

    def _asked(self, content: dict[str, Any], limit: float) -> dict[str, Any]:
        """Answer of the program."""
        program = self._program
        assert program.stdin is not None and program.stdout is not None
        try:
            program.stdin.write(json.dumps(content) + "\n")
            program.stdin.flush()
        except OSError:
            raise PeerError(self._ending()) from None
        if not select.select([program.stdout], [], [], limit)[0]:
            program.kill()
            raise PeerError(f"no answer within {limit:g} s")
        line = program.stdout.readline()
        try:
            answer: dict[str, Any] = json.loads(line)
        except ValueError:
            raise PeerError(self._ending() if not line else f"it says {line.strip()!r}") from None
        return answer

    def _ending(self) -> str:
        """How the program ended, with its last words."""
        with contextlib.suppress(subprocess.TimeoutExpired):
            self._program.wait(1.0)
        self._errors.seek(0)
        words = self._errors.read().strip().splitlines()
        last = f": {words[-1]}" if words else ""
        return f"its program ended with code {self._program.poll()}{last}"


def own_interpreter() -> str | None:
    """This interpreter, if it has acados_template."""
    return sys.executable if importlib.util.find_spec("acados_template") else None


@contextlib.contextmanager
def acados_peers(
    interpreter: str | None, problem: OptimalControlProblem, say: Callable[[str], None]
) -> Iterator[dict[str, AcadosPeer]]:
    """The peers that can be had, by name; what cannot is said in a line, as is one that was lost.

    Args:
        interpreter: Python that has acados_template; None for no peers.
        problem: What they solve.
        say: Called with such a line.

    Yields:
        Solvers by name, ended behind the block; one that was lost is then no longer among them.
    """
    peers: dict[str, AcadosPeer] = {}
    try:
        for name in KINDS if interpreter is not None else ():
            try:
                peers[name] = AcadosPeer(problem, name, str(interpreter))
            except PeerError as error:
                say(f"{name} is left out: {error}")
                break  # what one lacks, the other does
        yield peers
    finally:
        for name, peer in [*peers.items()]:
            peer.close()
            if peer.lost:
                say(f"{name} is left out: {peer.lost}")
                del peers[name]


def _told(problem: OptimalControlProblem, kind: str) -> dict[str, Any]:
    """The problem as the program is told."""
    symbols = [problem.state, problem.inputs, problem.parameter, problem.decision]
    hard, soft, penalties = hard_and_soft(problem.stage_inequalities)
    end_hard, end_soft, end_penalties = hard_and_soft(problem.terminal_inequalities)
    stage = [problem.next_state, problem.stage_cost, hard, soft]
    end = [problem.terminal_cost, problem.terminal_equality, end_hard, end_soft]
    return {
        "name": "tracking",
        "kind": kind,
        "horizon": problem.horizon,
        "sizes": {"x": problem.nx, "u": problem.nu, "p": problem.np, "a": problem.na},
        "stage": _listed(ca.Function("stage", symbols, stage)),
        "end": _listed(ca.Function("end", symbols, end)),
        "stage_penalties": np.array(penalties).ravel().tolist(),
        "end_penalties": np.array(end_penalties).ravel().tolist(),
        **{
            f"{name}_{side}": np.asarray(getattr(problem, f"{name}_{side}")).tolist()
            for name in ("input", "decision")
            for side in ("lower", "upper")
        },
    }


def _listed(function: ca.Function) -> dict[str, Any]:
    """A function as operations: name, where results go, operands, value of a constant."""
    operations = []
    for index in range(function.n_instructions()):
        name = OPERATIONS[function.instruction_id(index)]
        value = function.instruction_constant(index) if name == "OP_CONST" else None
        outputs, inputs = function.instruction_output(index), function.instruction_input(index)
        operations.append([name, list(outputs), list(inputs), value])
    return {
        "operations": operations,
        "sizes": [function.numel_out(index) for index in range(function.n_out())],
    }


def main(words: Sequence[str]) -> int:
    """Run the command of the package with these peers.

    Args:
        words: Command line.

    Returns:
        Exit code.
    """
    parser = CommandParser(description=benchmark.DESCRIPTION)
    benchmark.add_arguments(parser)
    parser.add_argument(
        "--acados",
        metavar="PYTHON",
        help="a Python interpreter that has acados_template (default: this one, if it has)",
    )
    arguments = parser.parse_args(words)
    peers = partial(acados_peers, arguments.acados or own_interpreter())
    with explained("benchmark with acados") as ending:
        ending.code = benchmark.run(arguments, peers)
    return ending.code


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
