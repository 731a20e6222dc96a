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

"""The example with acados, a peer behind pipes: what it is told, answers, and how it is missed."""

import json
import sys

import casadi as ca
import numpy as np
import pytest
from sources import ROOT, loaded

from uav_tracking_mpc.mpc.newton_solver import NewtonSolver
from uav_tracking_mpc.studies.benchmark import benchmark_study
from uav_tracking_mpc.studies.benchmark.benchmark_study import (
    OURS,
    flight_case,
    measure,
    paper_case,
    summary,
)

EXAMPLE = ROOT / "examples" / "acados"
acados = loaded(EXAMPLE / "benchmark.py", "acados_benchmark")
rebuilt = loaded(EXAMPLE / "acados_program.py").rebuilt
AcadosPeer, PeerError = acados.AcadosPeer, acados.PeerError

# Answers with the plan that it is given, after a second by its own clock; ends when told to.
ECHO = """
import json, sys
told = json.loads(sys.stdin.readline())
print(json.dumps({"ready": True, "kind": told["kind"]}), flush=True)
for number, line in enumerate(sys.stdin):
    asked = json.loads(line)
    if number == LAST:
        sys.exit("out of memory")
    answer = {name: asked[name] for name in ("states", "inputs", "decision")}
    print(json.dumps({**answer, "status": 0, "time": 1.0, "iterations": 7}), flush=True)
"""


@pytest.fixture
def program(tmp_path, monkeypatch):
    def write(text):
        file = tmp_path / "program.py"
        file.write_text(text)
        monkeypatch.setattr(acados, "PROGRAM", file)

    return write


@pytest.fixture(scope="module")
def case():
    return paper_case(10)


def test_a_peer_is_timed_by_its_own_clock_and_judged_by_the_common_measure(case, program):
    program(ECHO.replace("LAST", "-1"))
    said = []
    with acados.acados_peers(sys.executable, case.problem, said.append) as peers:
        assert set(peers) == {"acados_sqp", "acados_rti"}
        solvers = {OURS: NewtonSolver(case.problem), **peers}
        rows = summary(measure(case, solvers, repetitions=1, cold=2, peers_cold=2, seed=0))
    assert said == []
    for name in peers:
        assert rows[name]["transient_median_us"] == rows[name]["p99_us"] == 1e6
        assert rows[name]["alternating_median_us"] == 1e6
        assert rows[name]["cold_median_us"] == 2e6  # from two guesses
        assert rows[name]["iterations_median"] == 7
        assert (
            rows[name]["kkt_median"] > 1e-3
        )  # the guess given back is no solution, whatever it says
        assert rows[name]["closed_loop_cost"] > rows[OURS]["closed_loop_cost"]
        assert rows[name]["best_cost_share"] < 1.0
    assert rows[OURS]["kkt_median"] < 1e-6
    assert rows[OURS]["transient_median_us"] < 1e6


def test_a_peer_that_ends_in_the_middle_is_left_out_in_one_line(case, program):
    program(ECHO.replace("LAST", "3"))
    said = []
    with acados.acados_peers(sys.executable, case.problem, said.append) as peers:
        peer = peers["acados_sqp"]
        found = [peer.solve(case.start.state) for _ in range(3)]
    assert [solution.converged for solution in found] == [True, False, False]
    assert found[1].inputs.shape == (10, 3)
    assert said == ["acados_sqp is left out: its program ended with code 1: out of memory"]
    assert list(peers) == ["acados_rti"]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ('print(\'{"error": "no acados"}\')', "acados_sqp is left out: no acados"),
        ("print('hello')", "acados_sqp is left out: it says 'hello'"),
        ("raise SystemExit('no compiler')", "its program ended with code 1: no compiler"),
    ],
)
def test_a_peer_that_does_not_start_is_left_out(text, words, case, program):
    program(text)
    said = []
    with acados.acados_peers(sys.executable, case.problem, said.append) as peers:
        assert peers == {}
    assert len(said) == 1
    assert words in said[0]


def test_an_interpreter_without_acados_or_none_at_all(case):
    with pytest.raises(PeerError, match="No module named 'acados'"):
        AcadosPeer(case.problem, "acados_sqp", sys.executable)
    with pytest.raises(PeerError, match="/nowhere/python cannot be started: No such file"):
        AcadosPeer(case.problem, "acados_sqp", "/nowhere/python")
    with acados.acados_peers(None, case.problem, pytest.fail) as peers:
        assert peers == {}


def test_a_silent_peer_is_not_waited_for_without_end(case, program, monkeypatch):
    program("import time\ntime.sleep(60)")
    monkeypatch.setattr(acados, "BUILD_LIMIT", 0.2)
    with pytest.raises(PeerError, match=r"no answer within 0\.2 s"):
        AcadosPeer(case.problem, "acados_sqp", sys.executable)


@pytest.mark.parametrize("make", [lambda: paper_case(10, ellipsoid=True), flight_case])
def test_the_equations_survive_the_journey(make):
    problem = make().problem
    told = acados._told(problem, "sqp")
    symbols = [problem.state, problem.inputs, problem.parameter, problem.decision]
    again = [ca.SX.sym(str(k), symbol.numel()) for k, symbol in enumerate(symbols)]
    random = np.random.default_rng(1)
    point = [random.uniform(0.5, 1.5, symbol.numel()) for symbol in symbols]
    there = ca.Function("there", again, rebuilt(told["stage"], again))(*point)
    here = ca.Function("here", symbols, [problem.next_state, problem.stage_cost])(*point)
    for sent, kept in zip(there, here, strict=False):
        np.testing.assert_array_equal(np.array(sent), np.array(kept))


def test_the_example_is_the_command_with_two_more_solvers(program, monkeypatch, capsys):
    program(ECHO.replace("LAST", "-1"))
    monkeypatch.setattr(benchmark_study, "cases", lambda: [paper_case(10)])
    words = ["--quick", "--cold", "1", "--peers-cold", "1", "--acados", sys.executable, "--json"]
    assert acados.main(words) == 0
    (solvers,) = json.loads(capsys.readouterr().out)["cases"].values()
    assert {OURS, "acados_sqp", "acados_rti"} <= set(solvers)
