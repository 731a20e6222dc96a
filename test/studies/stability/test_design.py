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

"""Design help."""

import pytest

pytest.importorskip("flint")

from uav_tracking_mpc.dynamics.orbit import Orbit
from uav_tracking_mpc.studies.stability.design import design
from uav_tracking_mpc.terminal.stability_problem import paper_problem


def test_heavier_input_weight_enlarges_the_region_at_a_cost():
    found = design(paper_problem(), scalings=(2.5,), input_factors=(3.0,))
    assert found.best is not None
    assert found.best.volume > 2.0
    assert found.best.cost > 1.0
    assert found.best.proved


def test_impossible_orbit_is_explained():
    problem = paper_problem(orbit=Orbit(range=51.0, altitude=50.0, speed=9.0))
    found = design(problem, scalings=(2.5,), input_factors=(1.0,))
    assert found.best is None
    assert "no choice" in found.words
    assert "u_psi" in found.words
