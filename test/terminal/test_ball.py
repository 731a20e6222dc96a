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

"""Ball arithmetic encloses what floating point samples."""

import casadi as ca
import numpy as np
import pytest

flint = pytest.importorskip("flint")

from uav_tracking_mpc.dynamics.relative import rates_function  # noqa: E402
from uav_tracking_mpc.parameters.registry import RELATIVE_MODEL  # noqa: E402
from uav_tracking_mpc.terminal.ball import BallFunction  # noqa: E402


@pytest.mark.parametrize("model", RELATIVE_MODEL.names)
def test_enclosure_holds_samples(model):
    function = rates_function(model)
    enclose = BallFunction(function)
    generator = np.random.default_rng(0)
    center = np.array([150.0, 1.5, 50.0, 0.1, 4.0])
    half = np.array([5.0, 0.3, 5.0, 0.3, 0.5])
    box = [flint.arb(c, h) for c, h in zip(center, half, strict=True)]
    (rates,) = enclose(box, [flint.arb(0)] * 3)
    for _ in range(200):
        x = center + half * generator.uniform(-1.0, 1.0, 5)
        sample = np.array(function(x, np.zeros(3))).ravel()
        for ball, value in zip(rates, sample, strict=True):
            assert float(ball.lower()) - 1e-12 <= value <= float(ball.upper()) + 1e-12


def test_unknown_operation_is_refused():
    x = ca.SX.sym("x")
    with pytest.raises(NotImplementedError):
        BallFunction(ca.Function("f", [x], [ca.erf(x)]))


def test_root_of_a_negative_number_proves_nothing():
    x = ca.SX.sym("x")
    ((root,),) = BallFunction(ca.Function("f", [x], [ca.sqrt(x)]))([flint.arb(0, 1)])
    assert not root < 1e9
    assert not root > -1e9
