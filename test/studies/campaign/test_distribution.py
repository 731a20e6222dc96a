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

import numpy as np
import pytest
from scipy import stats

from uav_tracking_mpc.parameters.specification import ParameterError
from uav_tracking_mpc.studies.campaign.distribution import Distribution


def drawn(written, count=2000, **within):
    draw, random = Distribution.of("key", written), np.random.default_rng(8)
    if within:
        return [draw.draw_within(random, **within) for _ in range(count)]
    return [draw.draw(random) for _ in range(count)]


@pytest.mark.parametrize(
    ("written", "distribution"),
    [
        ({"uniform": [2.0, 5.0]}, stats.uniform(2.0, 3.0)),
        ({"log_uniform": [0.1, 10.0]}, stats.loguniform(0.1, 10.0)),
        ({"normal": [1.0, 3.0]}, stats.norm(1.0, 3.0)),
    ],
)
def test_numbers_are_distributed_as_they_are_called(written, distribution):
    assert stats.kstest(drawn(written), distribution.cdf).pvalue > 0.01


def test_a_choice_takes_all_alike():
    values = drawn({"choice": ["a", True, 3]})
    assert {str(value) for value in values} == {"a", "True", "3"}
    assert abs(values.count("a") / len(values) - 1.0 / 3.0) < 0.05


def test_a_value_is_itself():
    assert set(drawn(4.5, 3)) == {4.5}
    assert drawn([1.0, 2.0], 1) == [[1.0, 2.0]]


def test_half_the_range_is_half_way_from_what_is_right():
    values = drawn({"uniform": [0.0, 3.0]}, neutral=1.0, share=0.5)
    assert 0.5 <= min(values) < 0.51
    assert 1.99 < max(values) <= 2.0


def test_half_of_a_choice_is_made_in_half_of_the_flights():
    values = drawn({"choice": ["zigzag"]}, neutral="line", share=0.5)
    assert abs(values.count("zigzag") / len(values) - 0.5) < 0.05
    assert set(values) == {"zigzag", "line"}


def test_what_is_constant_is_not_shared():
    assert set(drawn(5.0, 3, neutral=10.0, share=0.5)) == {5.0}


def test_a_grid_is_evenly_spaced():
    grid = Distribution.of("key", {"grid": [0.0, 1.0, 5]})
    assert grid.swept
    assert grid.arguments == (0.0, 0.25, 0.5, 0.75, 1.0)
    assert Distribution.of("key", {"values": [1, "b"]}).arguments == (1, "b")


@pytest.mark.parametrize(
    ("written", "words"),
    [
        ({"triangle": [0, 1]}, "must be a value or one of uniform, log_uniform"),
        ({"uniform": 3.0}, "with a list"),
        ({}, "must be a value or one of"),
        ({"uniform": [1.0]}, "must have 2 values"),
        ({"choice": []}, "must have at least one values"),
        ({"uniform": [1.0, 0.0]}, "in order"),
        ({"uniform": ["a", 0.0]}, "finite numbers"),
        ({"normal": [0.0, -1.0]}, "standard deviation"),
        ({"log_uniform": [0.0, 1.0]}, "positive"),
        ({"grid": [0.0, 1.0, 2.5]}, "how many"),
        ({"uniform": [0.0, float("inf")]}, "finite"),
    ],
)
def test_what_is_none_is_refused(written, words):
    with pytest.raises(ParameterError, match=words):
        Distribution.of("wind.speed", written)
