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

"""One stage of a law's flight on the prediction, inputs kept to what can be flown."""

from __future__ import annotations

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.dynamics.buffered_function import BufferedFunction
from uav_tracking_mpc.mpc.problem import OptimalControlProblem


class LawStage:
    """Shares and next state of the flight problem where a law flies.

    Args:
        problem: The flight problem.
        wanted: Symbol of (u_psi, u_chi, u_v) that the law asks for, SX (3, 1).
        shares: Input shares of them in the symbols of the problem, SX (nu, 1), not yet clipped.
    """

    def __init__(self, problem: OptimalControlProblem, wanted: ca.SX, shares: ca.SX) -> None:
        x, p = problem.state, problem.parameter
        nearest = ca.fmin(ca.fmax(shares, problem.input_lower), problem.input_upper)
        step = ca.Function("step", [x, problem.inputs, p], [problem.next_state])
        results = [ca.densify(nearest), ca.densify(step(x, nearest, p))]
        function = ca.Function("law_stage", [x, wanted, p], results)
        self._function = BufferedFunction(function)

    def __call__(
        self, x: NDArray[np.float64], wanted: NDArray[np.float64], p: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Fly one stage.

        Args:
            x: State of the problem, shape (nx,).
            wanted: (u_psi, u_chi, u_v) that the law asks for in [rad/s, rad/s, m/s^2], shape (3,).
            p: Parameter of the stage, shape (np,).

        Returns:
            The shares nearest to them, shape (nu,), and the next state, shape (nx,): arrays that
            the next call overwrites.
        """
        for kept, values in zip(self._function.arguments, (x, wanted, p), strict=True):
            kept[:] = values
        self._function.evaluate()
        shares, following = self._function.results
        return shares, following
