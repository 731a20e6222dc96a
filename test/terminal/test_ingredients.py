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

from uav_tracking_mpc.dynamics.relative import error_dynamics, steady_inputs
from uav_tracking_mpc.symbolic.functions import linearise
from uav_tracking_mpc.terminal.ingredients import input_limited_level, terminal_ingredients

U = np.array([np.pi / 4, np.pi / 4, 1.0])


@pytest.fixture(params=["exact", "paper"])
def case(request, orbit, weights):
    a, b = linearise(error_dynamics(request.param, orbit, 1.0))
    return request.param, a, b, terminal_ingredients(a, b, *weights, 2.5)


def test_riccati_equation_28_holds(case, weights):
    _, _, _, ingredients = case
    q, r = weights
    k, p, a_k = ingredients.gain, ingredients.weight, ingredients.closed_loop
    residual = a_k.T @ p @ a_k - p + 2.5 * (q + k.T @ r @ k)
    np.testing.assert_allclose(residual, 0.0, atol=1e-10)
    np.testing.assert_allclose(ingredients.weight, 2.5 * ingredients.riccati)


def test_gain_24_minimises_the_one_step_cost(case, weights):
    _, a, b, ingredients = case
    q, r = weights
    x = np.array([3.0, 0.1, -2.0, 0.05, 0.4])

    def cost(u):
        following = a @ x + b @ u
        return x @ q @ x + u @ r @ u + following @ ingredients.riccati @ following

    best = ingredients.gain @ x
    for direction in np.eye(3):
        assert cost(best) < min(cost(best + 1e-3 * direction), cost(best - 1e-3 * direction))


def test_local_controller_stabilises_the_linearisation(case):
    assert np.max(np.abs(np.linalg.eigvals(case[3].closed_loop))) < 1.0


def test_level_25_touches_the_box_and_never_leaves_it(case, orbit):
    """The largest K x over the ellipsoid reaches one bound of U and passes none."""
    model, _, _, ingredients = case
    u_ss = steady_inputs(model, orbit)
    lower, upper = -U - u_ss, U - u_ss
    level = input_limited_level(ingredients, lower, upper)
    root = np.linalg.cholesky(np.linalg.inv(ingredients.weight))
    random = np.random.default_rng(0).standard_normal((5, 20000))
    states = np.sqrt(level) * root @ (random / np.linalg.norm(random, axis=0))
    inputs = ingredients.gain @ states
    assert np.all(inputs <= upper[:, None] + 1e-12)
    assert np.all(inputs >= lower[:, None] - 1e-12)
    worst = [
        np.sqrt(level) * np.linalg.norm(row @ root) / min(-low, high)
        for row, low, high in zip(ingredients.gain, lower, upper, strict=True)
    ]
    assert max(worst) == pytest.approx(1.0)


def test_levels_of_the_paper(orbit, weights):
    """u_chi binds at 2.878 in the exact model; |u_psi| alone would allow 3.197."""
    parts = terminal_ingredients(*linearise(error_dynamics("exact", orbit, 1.0)), *weights, 2.5)
    u_ss, alone = steady_inputs("exact", orbit), np.array([np.pi / 4, 1e3, 1e3])
    assert input_limited_level(parts, -U - u_ss, U - u_ss) == pytest.approx(2.878, abs=5e-4)
    assert input_limited_level(parts, -alone, alone) == pytest.approx(3.197, abs=0.3)


def test_what_has_no_terminal_set_is_refused(case, weights):
    _, a, b, ingredients = case
    with pytest.raises(ValueError, match="steady inputs are not inside"):
        input_limited_level(ingredients, np.array([0.1, -1, -1]), np.ones(3))
    with pytest.raises(ValueError, match="rho is 0.5"):
        terminal_ingredients(a, b, *weights, 0.5)
    with pytest.raises(ValueError, match="no stabilising"):
        terminal_ingredients(2.0 * np.eye(5), np.zeros((5, 3)), *weights, 1.0)
