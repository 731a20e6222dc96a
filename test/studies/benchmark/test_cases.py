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

"""The problems of the benchmark are those that are flown."""

import numpy as np
import pytest

from uav_tracking_mpc.formulation.flight_formulation import FlightFormulation
from uav_tracking_mpc.settings.configuration import load_configuration
from uav_tracking_mpc.studies.benchmark.cases import cases, flight_case

NAMES = ["paper_n10", "paper_n10_ellipsoid", "paper_n30", "paper_n30_ellipsoid", "flight_n20"]


@pytest.fixture(scope="module")
def all_cases():
    return {case.name: case for case in cases()}


def test_names_are_those_that_readers_of_the_json_expect(all_cases):
    assert list(all_cases) == NAMES


@pytest.mark.parametrize("name", NAMES)
def test_random_starts_are_repeatable_and_fit_the_problem(name, all_cases):
    case = all_cases[name]
    starts, again = case.cold_starts(20, 4), case.cold_starts(20, 4)
    for one, other in zip(starts, again, strict=True):
        np.testing.assert_array_equal(one.state, other.state)
        assert one.state.shape == (case.problem.nx,)
        assert np.all(np.isfinite(one.state))
    assert len({tuple(start.state) for start in starts}) == 20


def test_flight_starts_have_their_own_drift(all_cases):
    starts = all_cases["flight_n20"].cold_starts(20, 4)
    assert len({start.parameters.tobytes() for start in starts}) > 10


def test_the_flight_case_is_the_problem_of_small_uav():
    """Same expressions as in flight, but for the horizon: a flight of N = 22 tells them apart."""
    flown = FlightFormulation(load_configuration("small_uav").controller).solver.problem
    timed = flight_case(flown.horizon).problem
    for part in ("stage_cost", "next_state", "terminal_cost", "terminal_equality"):
        assert str(getattr(timed, part)) == str(getattr(flown, part))
    np.testing.assert_array_equal(timed.input_lower, flown.input_lower)
    assert flight_case().problem.horizon == 20
