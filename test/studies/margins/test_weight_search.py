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

"""The search finds the least cost among weights with the margins, which are formulas here."""

import math
from dataclasses import replace
from types import SimpleNamespace

import pytest
import yaml

from uav_tracking_mpc.margins.loop_margins import CHANNELS, ChannelMargins
from uav_tracking_mpc.parameters.specification import ParameterError
from uav_tracking_mpc.studies.comparison.measures import Measures
from uav_tracking_mpc.studies.margins import weight_search as module
from uav_tracking_mpc.studies.margins.weight_search import search_weights


class Loop:
    """Delay margins grow with the input weights, the gain margin is always the same."""

    def __init__(self, parameters):
        self.change(parameters)

    def change(self, parameters):
        self.input_weights = parameters.input_weights

    def orbit_in(self, drift, azimuth=0.0):
        return azimuth

    def margins(self, frozen):
        less = 0.99 if frozen else 1.0  # in wind
        channels = {
            name: ChannelMargins(8.0, 8.0, math.inf, 40.0, less * 0.3 * weight, 1.0, 0.8)
            for name, weight in zip(CHANNELS, self.input_weights, strict=True)
        }
        return SimpleNamespace(channels=channels)


@pytest.fixture(autouse=True)
def formulas(monkeypatch):
    monkeypatch.setattr(module, "OrbitLoop", Loop)


SEARCHED = ("input_weights", "rate_weights")
# What the formulas here begin with, whatever the configuration has.
START = (
    "nmpc_controller.input_weights=[10.0, 2.0, 1.0]",
    "nmpc_controller.rate_weights=[10.0, 2.0, 1.0]",
)
FLIGHT = Measures(0.0, 0.0, 0.0, 20.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0, {}, None)


def flights(cost):
    """Flights of which weights make the range RMS."""

    def parallel_map(function, tasks, workers, label, show):
        found = []
        for _, name, overrides in tasks:
            told = dict(override.split("=") for override in overrides)
            parts = [yaml.safe_load(told[f"nmpc_controller.{each}"]) for each in SEARCHED]
            range_rms, _ = module.FLIGHTS[name]
            value = cost([*parts[0], *parts[1]]) * range_rms
            found.append(replace(FLIGHT, range_rms_m=value))
        return found

    return parallel_map


def quadratic(weights):
    """Least at an input weight of the turn rate of 30 and a rate weight of the path angle of 1."""
    return 1.0 + math.log10(weights[0] / 30.0) ** 2 + math.log10(weights[4] / 1.0) ** 2


def searched(start=START, **options):
    """What was tried, and the best of it."""
    content = search_weights("small_uav", start, flights=["lag_2"], show=False, **options).content
    return content["candidates"], content["best"]


def test_it_goes_where_the_cost_is_least(monkeypatch):
    monkeypatch.setattr(module, "parallel_map", flights(quadratic))
    study = search_weights("small_uav", START, flights=["lag_2"], show=False)
    best, candidates = study.content["best"], study.content["candidates"]
    assert best["input_weights"][0] == pytest.approx(30.0, rel=0.3)
    assert best["rate_weights"][1] == pytest.approx(1.0, rel=0.3)
    assert best["delay_s"] >= 0.3
    assert best["cost"] == min(each["cost"] for each in candidates if each["flights"])
    pasted = yaml.safe_load(study.content["yaml"])["/**/nmpc_controller"]["ros__parameters"]
    assert pasted == {name: best[name] for name in module.SIZES}
    table, yaml_text = study.words
    assert yaml_text == study.content["yaml"]
    assert len(table.rows) == len(candidates)


def test_weights_without_margins_are_not_flown(monkeypatch):
    """The cost would have them smaller and smaller."""
    monkeypatch.setattr(module, "parallel_map", flights(lambda weights: weights[1]))
    candidates, best = searched()
    assert 1.0 / 0.99 <= best["input_weights"][1] < 2.0
    assert best["delay_s"] >= 0.3
    small = [each for each in candidates if each["shortfalls"]]
    assert small
    assert all(not each["flights"] and each["cost"] is None for each in small)


def test_from_weights_without_margins_it_finds_some(monkeypatch):
    monkeypatch.setattr(module, "parallel_map", flights(quadratic))
    candidates, best = searched(["nmpc_controller.input_weights=[0.5, 0.3, 0.2]", START[1]])
    assert candidates[0]["shortfalls"]
    assert not best["shortfalls"]


def test_no_weights_have_such_margins(monkeypatch):
    monkeypatch.setattr(module, "parallel_map", flights(quadratic))
    asked = [*START, "nmpc_controller.gain_margin_min=9.0"]
    with pytest.raises(ParameterError, match="none of 15 weights"):
        searched(asked, rounds=1)


def test_the_papers_problem_is_not_searched():
    with pytest.raises(ParameterError, match="terminal_constraint"):
        search_weights("paper", flights=["lag_2"], show=False)


def test_the_range_is_weighted_with_its_orbit(monkeypatch):
    monkeypatch.setattr(module, "parallel_map", flights(lambda weights: 1.0))
    candidates, _ = searched(rounds=1)
    begin = candidates[0]
    ratios = {
        tuple(
            round(each[name][0] / begin[name][0], 1) for name in ("state_weights", "offset_weights")
        )
        for each in candidates
    }
    assert len(ratios) == 3
    assert all(one == pytest.approx(other, rel=0.1) for one, other in ratios)
