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

"""The whole analysis, the levels that it must reach, and help with the design."""

import pytest

from uav_tracking_mpc.dynamics.orbit import Orbit
from uav_tracking_mpc.studies.stability.analysis import analyse
from uav_tracking_mpc.studies.stability.stability_study import as_json, as_words, design
from uav_tracking_mpc.terminal.ingredients import paper_problem

TIGHT = Orbit(range=51.0, altitude=50.0, speed=9.0)


@pytest.fixture(scope="module")
def model_11():
    return analyse(paper_problem("paper"))


def test_levels_of_11_are_proved_below_their_violations(model_11):
    content = as_json(model_11)
    assert set(model_11.reaches) == {"theorem2", "theorem3", "decrease"}
    assert model_11.reaches["theorem3"].proved >= 0.22
    assert model_11.reaches["decrease"].proved >= 4.7
    for name, reach in model_11.reaches.items():
        assert 0.0 < content["varrho"][name] == reach.proved < reach.violation.level
    assert content["varrho"]["inputs"] >= content["varrho"]["certified"] > 0.0
    assert content["violated_at"]["decrease_confirmed"] is content["certified"] is True
    assert set(content["conditions"]["theorem3"]) == {"holds", "left", "right"}
    bound = content["lipschitz"]
    assert bound["lower"] <= bound["upper"] <= 1.05 * bound["lower"]
    assert "CERTIFIED" in as_words(model_11) and "u_chi" in as_words(model_11)


def test_orbit_too_tight_for_the_turn_rate_says_so():
    found = analyse(paper_problem(orbit=TIGHT), boxes=100)
    assert not found.certified
    assert "steady input" in found.binding
    assert as_json(found)["varrho"]["certified"] == 0.0
    assert "NOT CERTIFIED" in as_words(found)


def test_a_search_that_stops_for_its_budget_says_so_and_what_to_do():
    found = analyse(paper_problem(), boxes=3)
    assert not found.certified
    *_, verdict = as_words(found).splitlines()
    assert "NOT CERTIFIED" in verdict
    assert "budget of 3 boxes is spent" in verdict
    assert "--boxes" in verdict


def test_heavier_input_weight_enlarges_the_region_at_a_cost():
    study = design(paper_problem(), scalings=(2.5,), input_factors=(3.0,))
    best = study.content["best"]
    assert study.good
    assert best["volume"] > 2.0
    assert best["cost"] > 1.0
    assert best["proved"]
    assert study.content["asked"]["volume"] == study.content["asked"]["cost"] == 1.0


def test_impossible_orbit_is_explained():
    study = design(paper_problem(orbit=TIGHT), scalings=(2.5,), input_factors=(1.0,))
    assert not study.good
    assert study.content["best"] is None
    words, _ = study.words
    assert "no choice" in words
    assert "u_psi" in words
