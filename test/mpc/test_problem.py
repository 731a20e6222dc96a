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

import casadi as ca
import numpy as np
import pytest
from solver_problems import integrator

from uav_tracking_mpc.mpc.problem import Inequality


def test_sizes_are_those_of_the_symbols():
    problem = integrator()
    assert (problem.nx, problem.nu, problem.np, problem.na) == (2, 1, 0, 0)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"horizon": 0}, "horizon is 0"),
        ({"step": 0.0}, "step is 0.0"),
        ({"step": np.nan}, "step is nan"),
        ({"input_lower": np.array([1.0])}, "lower must be below upper"),
        ({"input_lower": np.array([-1.0, -1.0])}, "shapes"),
        ({"input_upper": np.array([np.nan])}, "lower must be below upper"),
        ({"next_state": lambda x, u: x[0]}, "next_state has shape"),
        ({"continuation": lambda x, u: x}, "continuation has shape"),
        ({"terminal_cost": lambda x, u: ca.sumsqr(u)}, "must not depend on the inputs"),
        ({"decision_guess": np.zeros(1)}, "decision_guess"),
    ],
)
def test_what_does_not_fit_is_refused_by_name(changes, message):
    with pytest.raises(ValueError, match=message):
        integrator(**changes)


@pytest.mark.parametrize("penalty", [0.0, -1.0, np.inf, np.nan])
def test_soft_inequality_needs_a_penalty_that_penalises(penalty):
    with pytest.raises(ValueError, match="penalty of 'speed'"):
        Inequality(ca.SX.sym("h"), penalty, "speed")
