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

"""Certificates: the checker accepts what is proved and nothing else; what may be claimed."""

import copy
import json
import operator
import re
from dataclasses import replace
from functools import partial
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from uav_tracking_mpc.control.certification import certificate_status
from uav_tracking_mpc.dynamics.relative_models.kinematics import Exact
from uav_tracking_mpc.studies.stability.proof import certificate, prove_direct_condition
from uav_tracking_mpc.terminal import certificate as certificate_module
from uav_tracking_mpc.terminal import interval, quadratic_bound
from uav_tracking_mpc.terminal.certificate import digest, mismatch, read_certificate, verify
from uav_tracking_mpc.terminal.ingredients import paper_problem


def write(problem, level):
    parts = problem.ingredients()
    proved = prove_direct_condition(problem, parts, level)
    return json.loads(json.dumps(certificate(problem, parts, proved)))


@pytest.fixture(scope="module")
def written():
    return write(paper_problem(), 2.87)


def ample(model, factor):
    base = paper_problem(model)
    return replace(
        base, input_lower=factor * base.input_lower, input_upper=factor * base.input_upper
    )


@pytest.mark.parametrize(
    ("problem", "level"),
    [
        (paper_problem(), 0.01),
        (paper_problem(), 2.87),
        (paper_problem("paper"), 2.8),
        (paper_problem("paper9"), 2.0),
        (ample("exact", 2.0), 11.4),  # all three bounds doubled: U allows 11.51
        (ample("paper", 4.0), 4.6),
        (paper_problem(scaling=5.0), 2.0),
        (paper_problem(step=0.5), 1.0),
        (paper_problem(scheme="rk4"), 0.8),
    ],
)
def test_accepts_every_kind(problem, level):
    assert verify(write(problem, level)) is None


def change(path, value):
    def apply(content):
        place = content
        for key in path[:-1]:
            place = place[key]
        place[path[-1]] = value(place[path[-1]]) if callable(value) else value

    return apply


CORRUPTIONS = {
    "level raised": change(["level"], lambda v: 1.01 * v),
    "level not a number": change(["level"], "much"),
    "level in words": change(["level"], "2.5"),
    "level negative": change(["level"], -1.0),
    "gain changed": change(["gain", 0, 1], lambda v: -v),
    "weight changed": change(["weight", 0, 0], lambda v: 1.5 * v),
    "weight not symmetric": change(["weight", 0, 1], lambda v: v + 1e-3),
    "weight not definite": change(["weight", 0, 0], -1.0),
    "tree cut short": change(["tree"], lambda v: v[:-1]),
    "tree too long": change(["tree"], lambda v: v + "."),
    "tree pruned to its root": lambda c: (
        change(["tree"], ".")(c),
        change(["multipliers"], [0.0])(c),
        change(["statistics", "leaves"], 1)(c),
    ),
    "tree with an unknown mark": change(["tree"], lambda v: "7" + v[1:]),
    "a multiplier is missing": change(["multipliers"], lambda v: v[:-1]),
    "a multiplier is negative": change(["multipliers"], lambda v: [*v[:-1], -1.0]),
    "root box smaller": change(["root"], lambda v: [0.9 * e for e in v]),
    "inputs narrower than proved": change(["problem", "input_upper", 1], 0.5),
    "another speed": change(["problem", "orbit", "speed"], 5.0),
    "another range": change(["problem", "orbit", "range"], 60.0),
    "another direction": change(["problem", "orbit", "direction"], "counter_clockwise"),
    "another model": change(["problem", "model"], "paper"),
    "another scheme": change(["problem", "scheme"], "rk4"),
    "another step": change(["problem", "step_s"], 1.2),
    "another rho": change(["problem", "scaling"], 2.0),
    "heavier state weight": change(["problem", "state_weight", 4, 4], 3.0),
    "heavier input weight": change(["problem", "input_weight", 0, 0], 3.0),
    "unknown format": change(["format"], "certificate 0"),
    "no tree": lambda c: c.pop("tree"),
    "nothing at all": dict.clear,
    "leaves miscounted": change(["statistics", "leaves"], 3),
}


@pytest.mark.parametrize("name", CORRUPTIONS)
def test_rejects_a_corrupted_certificate_even_with_a_fresh_digest(written, name):
    content = copy.deepcopy(written)
    CORRUPTIONS[name](content)
    assert verify(content) is not None
    content["digest"] = digest(content)
    assert verify(content) is not None


def test_a_number_beyond_all_doubles_covers_nothing(written):
    content = copy.deepcopy(written)
    content["gain"][0][0] = 10**400
    content["digest"] = digest(content)
    assert "malformed" in mismatch(content, PROBLEM, PARTS, 2.5)


def test_halves_of_a_leaf_that_cannot_be_exact_prove_nothing():
    """Their rounded middles could leave a gap between them."""
    undecided = np.zeros(1, dtype=bool)
    expansion = SimpleNamespace(influence=np.ones((1, 5)), in_floats=lambda: None)
    bound = SimpleNamespace(
        expansion=lambda *_: expansion, guess=lambda *_: None, confirmed=lambda *_: undecided
    )
    half = np.full((1, 5), 2.0**-53)
    with pytest.raises(certificate_module.RejectedError, match="not exact"):
        certificate_module._unconfirmed(bound, np.ones((1, 5)), half, np.zeros(1))


def test_rejects_a_wrong_digest(written):
    assert "digest" in verify({**written, "digest": "0" * 64})


def test_knows_nothing_of_the_search():
    modules = (certificate_module, quadratic_bound, interval)
    source = "".join(Path(module.__file__).read_text() for module in modules)
    imported = {line.split()[1] for line in source.splitlines() if line.startswith("from uav_")}
    own = {module.__name__ for module in modules}
    own.add("uav_tracking_mpc.terminal.ingredients")  # what is flown
    below = ("uav_tracking_mpc.dynamics.", "uav_tracking_mpc.symbolic")
    assert all(name in own or name.startswith(below) for name in imported)


def test_no_file_that_a_certificate_names_is_run(written, tmp_path):
    file = tmp_path / "model.py"
    file.write_text(f"open({str(tmp_path / 'was_run')!r}, 'w')\n")
    content = copy.deepcopy(written)
    content["problem"]["model"] = f"{file}:Exact"
    content["digest"] = digest(content)
    assert "model" in verify(content)
    assert not (tmp_path / "was_run").exists()


def test_rejects_when_the_model_is_wrong_in_a_rate_however_little(written, monkeypatch):
    right = Exact.rates

    def rates(self, state, inputs):
        found = right(self, state, inputs)
        found[2] = wrong(found[2])
        return found

    monkeypatch.setattr(Exact, "rates", rates)
    wrong = operator.neg
    assert verify(written) is not None
    wrong = partial(operator.add, 5e-10)
    assert "does not vanish" in verify(written)
    with pytest.raises(ArithmeticError, match="altitude"):
        write(paper_problem(), 1.0)


@pytest.mark.parametrize("rate", [1, 4])
def test_rejects_a_model_whose_rates_depend_on_the_turn_rate_otherwise(written, monkeypatch, rate):
    """Its steady input is not the one taken: f(0, 0) is not 0, which the test at the origin needs.

    Args:
        rate: That depends on it, though so little that no enclosure shows it.
    """
    right = Exact.rates

    def rates(self, state, inputs):
        found = right(self, state, inputs)
        found[rate] = found[rate] + 1e-12 * inputs[0] ** 2
        return found

    monkeypatch.setattr(Exact, "rates", rates)
    assert "does not vanish" in verify(written)


def test_rejects_a_level_that_keeps_no_margin_below_the_bound_of_an_input():
    problem = paper_problem()
    parts = problem.ingredients()
    bound = prove_direct_condition(problem, parts, 1.0).inputs
    level = bound.level * (1.0 - 1e-12)
    proved = prove_direct_condition(problem, parts, level)
    assert not proved.holds
    assert bound.name in proved.reason
    claimed = replace(proved, inputs=replace(bound, level=1.01 * level))
    content = json.loads(json.dumps(certificate(problem, parts, claimed)))
    assert "input 0 exceeds" in verify(content) or "input 1 exceeds" in verify(content)
    assert verify(write(problem, bound.level * (1.0 - 1e-6))) is None


PROBLEM = paper_problem()
PARTS = PROBLEM.ingredients()


WIDE = replace(PROBLEM, input_lower=np.full(3, -99.0), input_upper=np.full(3, 99.0))


@pytest.mark.parametrize(
    ("problem", "parts", "level", "proved", "status", "words"),
    [
        (PROBLEM, PARTS, 2.5, True, "certified", ""),
        (PROBLEM, PARTS, 1.0, True, "certified", ""),
        (replace(PROBLEM, horizon=20), PARTS, 2.5, True, "certified", ""),
        (PROBLEM, PARTS, 2.875, True, "sampled", "level"),
        (PROBLEM, replace(PARTS, gain=PARTS.gain * (1.0 + 1e-6)), 2.4, True, "sampled", "gain"),
        (WIDE, PARTS, 18.5, False, "neither", ""),  # a sample breaks the decrease
        (PROBLEM, PARTS, 4.0, False, "neither", ""),  # beyond the inputs
        (PROBLEM, PARTS, None, False, "neither", ""),  # without a set
        *(
            (changed, changed.ingredients(), 2.4, True, "(sampled|neither)", "void")
            for changed in (
                replace(PROBLEM, step=0.9),
                replace(PROBLEM, scaling=2.4),
                replace(PROBLEM, model="paper"),
                replace(PROBLEM, scheme="rk4"),
                replace(PROBLEM, orbit=replace(PROBLEM.orbit, speed=4.1)),
                replace(PROBLEM, state_weight=1.1 * PROBLEM.state_weight),
                replace(PROBLEM, input_weight=1.1 * PROBLEM.input_weight),
                replace(PROBLEM, input_upper=1.1 * PROBLEM.input_upper),
            )
        ),
    ],
)
def test_what_may_be_claimed(written, problem, parts, level, proved, status, words):
    content = written if proved else None
    answer = certificate_status(problem, parts, level, content, samples=2000)
    assert re.fullmatch(status, answer.status)
    assert words in answer.reason


def test_a_failed_proof_writes_no_certificate():
    with pytest.raises(ValueError, match="not proved"):
        certificate(PROBLEM, PARTS, prove_direct_condition(PROBLEM, PARTS, 3.5))


def test_file_round_trip(written, tmp_path):
    (tmp_path / "c.json").write_text(json.dumps(written))
    assert read_certificate(tmp_path / "c.json") == written
    (tmp_path / "deep.json").write_text("[" * 100_000)
    with pytest.raises(ValueError, match="no JSON"):
        read_certificate(tmp_path / "deep.json")
    (tmp_path / "list.json").write_text("[]")
    with pytest.raises(ValueError, match="no certificate"):
        read_certificate(tmp_path / "list.json")


def test_shipped_certificate_covers_the_papers_configuration():
    path = Path(__file__).resolve().parents[2] / "config" / "certificates" / "paper.json"
    content = read_certificate(path)
    answer = certificate_status(PROBLEM, PARTS, content["level"], content)
    assert answer.status == "certified"
    assert content["level"] > 2.85
