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

r"""The vehicle (3) behind inner loops that lag, in an air mass that drifts.

Each of the rates (psi', chi', v') follows its command u with a time constant tau,
:math:`\tau \dot\omega = u - \omega`; under held commands that has a closed solution, and so have
heading, path angle and airspeed:

.. math::

    \omega(t) = u + (\omega_0 - u) e^{-t/\tau}, \qquad
    \psi(t) = \psi_0 + u t + (\omega_0 - u)\, \tau (1 - e^{-t/\tau}).

Position relative to the target integrates air velocity plus drift; the air velocity by Simpson's
rule, exact to fourth order in the step.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.dynamics.energy_hold import HoldConstants, HoldParameters, hold
from uav_tracking_mpc.dynamics.vehicle import air_velocity
from uav_tracking_mpc.dynamics.vehicle_models import Drift, VehicleModel, VehicleState
from uav_tracking_mpc.parameters.specification import parameter


@dataclass(frozen=True)
class Lagged(VehicleModel):
    """First-order lag of turn rate, path-angle rate and acceleration."""

    name = "lagged"

    rate_lag: tuple[float, ...] = parameter(
        (0.0, 0.0, 0.0),
        "Time constants of the aircraft's turn rate, path-angle rate and acceleration.",
        "s",
        0.0,
        5.0,
        size=3,
    )

    def numbers(self, duration: float) -> NDArray[np.float64]:
        """See :meth:`VehicleModel.numbers`.

        Returns:
            tau (1 - e^(-t/tau)) after half the step and after all of it in [s], and e^(-t/tau)
            after all of it, for each of the three rates, shape (9,).
        """
        half = [math.exp(-0.5 * duration / tau) if tau > 0.0 else 0.0 for tau in self.rate_lag]
        whole = [share**2 for share in half]
        led = [
            tau * (1.0 - share)
            for shares in (half, whole)
            for tau, share in zip(self.rate_lag, shares, strict=True)
        ]
        return np.array([*led, *whole])

    @property
    def lags(self) -> NDArray[np.float64]:
        """See :attr:`VehicleModel.lags`."""
        return np.array(self.rate_lag)

    def with_lags(self, lags: NDArray[np.float64]) -> VehicleModel:
        """See :meth:`VehicleModel.with_lags`."""
        return replace(self, rate_lag=tuple(lags.tolist()))

    def step(
        self, state: VehicleState, inputs: Any, duration: Any, numbers: Any, drift: Drift
    ) -> VehicleState:
        """See :meth:`VehicleModel.step`."""
        xp = ca if isinstance(state.heading, ca.SX) else math
        x, y, z, psi, chi, v, turn, climb, gain = state
        u_psi, u_chi, u_v = inputs[0], inputs[1], inputs[2]
        # What each rate still lacks of its command, and how far that leads the angle astray.
        e_psi, e_chi, e_v = turn - u_psi, climb - u_chi, gain - u_v
        half = 0.5 * duration
        begin = air_velocity(psi, chi, v, xp)
        middle = air_velocity(
            psi + u_psi * half + e_psi * numbers[0],
            chi + u_chi * half + e_chi * numbers[1],
            v + u_v * half + e_v * numbers[2],
            xp,
        )
        psi = psi + u_psi * duration + e_psi * numbers[3]
        chi = chi + u_chi * duration + e_chi * numbers[4]
        v = v + u_v * duration + e_v * numbers[5]
        last = air_velocity(psi, chi, v, xp)
        dx, dy, dz = (
            duration / 6.0 * (begin[axis] + 4.0 * middle[axis] + last[axis])
            + duration * (drift.velocity[axis] + half * drift.rate[axis])
            for axis in range(3)
        )
        rates = (u_psi + e_psi * numbers[6], u_chi + e_chi * numbers[7], u_v + e_v * numbers[8])
        return VehicleState(x + dx, y + dy, z + dz, psi, chi, v, *rates)


@dataclass(frozen=True)
class Held(HoldParameters, Lagged):
    """First-order lag of a turn rate that is commanded and of two rates that hold what is told."""

    name = "held"
    commanded: ClassVar[int] = 1

    def numbers(self, duration: float) -> NDArray[np.float64]:
        """See :meth:`VehicleModel.numbers`.

        Returns:
            Those of :meth:`Lagged.numbers`, then the constants of the autopilot, shape (15,).
        """
        return np.concatenate([super().numbers(duration), self.hold_constants])

    def held(self, state: Any, altitude: Any, airspeed: Any, numbers: Any, drift: Any) -> list[Any]:
        """See :meth:`VehicleModel.held`."""
        xp = ca if isinstance(state.heading, ca.SX) else np
        climb_rate = state.airspeed * xp.sin(state.path_angle) + drift[2]
        constants = HoldConstants(*(numbers[k] for k in range(9, 15)))
        u_chi, u_v = hold(
            altitude - state.z,
            climb_rate,
            state.path_angle,
            state.airspeed,
            airspeed - state.airspeed,
            constants,
            xp,
        )
        return [u_chi, u_v]
