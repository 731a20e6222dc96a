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

"""The closed loop f(x, K x) with its derivatives, every number in it left open.

(10) in error form is f(x, u) = Phi(x_ss + x, u_ss + u) - x_ss, Phi one step of the model. Here
x_ss, u_ss, K and T_s are symbols, so that a proof can put in the exact values: theta_ss is pi/2,
not the double nearest to it, and u_ss is the turn rate that cancels the drift exactly. Then f(0,
0) = 0 holds as an identity: a steady state of the rates is a fixed point of every scheme.
"""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.dynamics.discretisation import error_step
from uav_tracking_mpc.dynamics.orbit import CLOCKWISE, Orbit
from uav_tracking_mpc.dynamics.relative import (
    NU,
    NX,
    RelativeState,
    rates_function,
    vanishing_rates,
)
from uav_tracking_mpc.terminal.ball import PRECISION, BallFunction, flint


def steady_balls(model: str, orbit: Orbit) -> tuple[list[Any], list[Any]]:
    """x_ss and u_ss of an orbit in ball arithmetic, pi/2 and the drift being exact.

    Args:
        model: Name of a relative model.
        orbit: Reference.

    Raises:
        ArithmeticError: The model's other rates do not vanish there: no steady state.
    """
    arb = flint().arb
    with flint().ctx.workprec(PRECISION):
        bearing = arb.pi() / 2 if orbit.direction == CLOCKWISE else -arb.pi() / 2
        x_ss = [arb(orbit.range), bearing, arb(orbit.altitude), arb(0), arb(orbit.speed)]
        (drift,) = BallFunction(rates_function(model))(x_ss, [arb(0)] * NU)
        rates = RelativeState(*drift)
        vanishes = vanishing_rates(model)._replace(bearing=True)._asdict()
        for name, rate in rates._asdict().items():
            if not vanishes[name]:
                raise ArithmeticError(
                    f"rate of {name} of model {model!r} at the orbit is {rate}, must be 0"
                )
        return x_ss, [-rates.bearing, arb(0), arb(0)]


class ClosedLoopBalls:
    """f(x, K x) of one configuration in ball arithmetic, with its derivatives.

    Attributes:
        pattern: For each of the five Hessians the places (i, j), i <= j, of its nonzeros.
        steady_state: x_ss.
        steady_inputs: u_ss.

    Args:
        model: Name of the model.
        scheme: Name of the scheme.
        orbit: Reference.
        step: T_s in [s], taken as the exact double.
        gain: K, shape (3, 5), taken as exact doubles.
    """

    def __init__(
        self, model: str, scheme: str, orbit: Orbit, step: float, gain: NDArray[np.float64]
    ) -> None:
        x = ca.SX.sym("x", NX)
        x_ss, u_ss = ca.SX.sym("x_ss", NX), ca.SX.sym("u_ss", NU)
        k, duration = ca.SX.sym("K", NU, NX), ca.SX.sym("T_s")
        numbers = ca.vertcat(x_ss, u_ss, ca.vec(k), duration)
        following = error_step(model, scheme, x, k @ x, x_ss, u_ss, duration)
        slopes = [following, ca.densify(ca.jacobian(following, x))]
        curvature, self.pattern = [], []
        for row in range(NX):
            upper = ca.sparsify(ca.triu(ca.hessian(following[row], x)[0]))
            self.pattern.append(list(zip(*upper.sparsity().get_triplet(), strict=True)))
            curvature.append(ca.vertcat(ca.SX.zeros(0, 1), *upper.nonzeros()))  # type: ignore[call-overload]
        self._first = BallFunction(ca.Function("first", [x, numbers], ca.cse(slopes)))
        self._second = BallFunction(ca.Function("second", [x, numbers], ca.cse(curvature)))
        arb = flint().arb
        self.steady_state, self.steady_inputs = steady_balls(model, orbit)
        entries = [arb(float(value)) for value in np.asarray(gain).ravel(order="F")]
        self._numbers = [*self.steady_state, *self.steady_inputs, *entries, arb(float(step))]

    def value_and_jacobian(self, x: list[Any]) -> tuple[list[Any], Any]:
        """Value f and Jacobian (an ``arb_mat``) over the box ``x`` of balls."""
        value, jacobian = self._first(x, self._numbers)
        rows = [jacobian[i::NX] for i in range(NX)]  # CasADi stores by columns
        return value, flint().arb_mat(rows)

    def curvature(self, x: list[Any]) -> list[list[Any]]:
        """Nonzeros of the Hessians' upper triangles, as ``pattern``, over the box ``x``."""
        return self._second(x, self._numbers)
