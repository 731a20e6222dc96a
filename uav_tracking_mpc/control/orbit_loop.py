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

r"""The controller's loop near its orbit: its answers to deviations, and the margins that follow.

Near a steady orbit the guidance is a static gain :math:`-K` of the situation in which its command
takes effect, here by central differences of its own answers. Around it lie the aircraft and the
prediction (:mod:`sampled_loop`). Estimators that are exact while all sensors are, such as those of
wind and target, do not show; nor does the time that a solve takes.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.control.guidance import formulation_of, law_about, law_of
from uav_tracking_mpc.control.loop_margins import UNSTABLE, LoopMargins, loop_margins
from uav_tracking_mpc.control.orbit_deviation import SIZE, STEPS, FrozenOrbit
from uav_tracking_mpc.control.sampled_loop import SampledLoop, sampled_loop
from uav_tracking_mpc.dynamics.response import Response
from uav_tracking_mpc.estimation.forecast import steady_forecast
from uav_tracking_mpc.estimation.situation import Situation
from uav_tracking_mpc.settings.tracking import TrackingParameters

SOLVE_TIME_MAX = 10.0  # s: nothing flies on these solves
# Of the inputs on the orbit off its own motion, in [rad/s, rad/s, m/s^2]: beyond them it is left.
STEADY = np.array([0.02, 0.02, 0.1])
FREQUENCIES = 400  # of a response: its margins are then within 1 % of those of 4000


class OrbitLoop:
    """Loops of one set of parameters, with a solver of its own.

    Args:
        parameters: What is flown.

    Raises:
        ParameterError: There is no such law, or the parameters cannot be flown.
    """

    def __init__(self, parameters: TrackingParameters) -> None:
        self._formulation = formulation_of(parameters)
        self._take(parameters)

    def change(self, parameters: TrackingParameters) -> None:
        """Use other parameters from now on, of which no fixed one differs.

        Args:
            parameters: The new ones.
        """
        if self._formulation is not None:
            self._formulation.change(parameters)
        self._take(parameters)

    def _take(self, parameters: TrackingParameters) -> None:
        self.parameters, law = parameters, law_of(parameters)
        self._law = None if law is None else law_about(law, parameters.orbit, parameters)
        self.told = parameters.response
        if self._formulation is not None:
            unhurried = replace(parameters, solve_time_max=SOLVE_TIME_MAX)
            self._formulation.change(unhurried)

    def orbit_in(self, drift: NDArray[np.float64], azimuth: float = 0.0) -> FrozenOrbit:
        """The orbit that is asked for, in a steady drift at one azimuth.

        Args:
            drift: c in the axes of ``map``, shape (3,), in [m/s].
            azimuth: phi in [rad].
        """
        return FrozenOrbit(self.parameters.orbit, drift, azimuth)

    def gain(self, frozen: FrozenOrbit) -> NDArray[np.float64]:
        """Effect of a deviation on the command, shape (3, 8), in SI units.

        Args:
            frozen: Where.

        Raises:
            ArithmeticError: The guidance has no answer there, or none that stays on the orbit.
        """
        if self._formulation is not None:
            self._formulation.reset()
        off = self._answer(frozen.situation(np.zeros(SIZE)), None) - frozen.motion()[-3:]
        if not (np.abs(off) <= STEADY).all():
            raise ArithmeticError("limits leave no steady orbit as it is asked for")
        gain = np.zeros((3, SIZE))
        for component, step in enumerate(STEPS):
            deviation = np.zeros(SIZE)
            deviation[component] = step
            above = self._answer(frozen.situation(deviation), 0.0)
            below = self._answer(frozen.situation(-deviation), 0.0)
            gain[:, component] = (above - below) / (2.0 * step)
        return gain

    def _answer(self, situation: Situation, elapsed: float | None) -> NDArray[np.float64]:
        if self._law is not None:
            return np.asarray(self._law.inputs(situation), dtype=float)
        assert self._formulation is not None
        ahead = steady_forecast(situation, self.parameters.horizon)
        orbit = self.parameters.orbit
        plan = self._formulation.solve(situation, ahead, orbit, elapsed)
        if not plan.solution.converged:
            raise ArithmeticError(f"the plan on the orbit: {plan.solution.message}")
        return plan.inputs[0]

    def loop(self, frozen: FrozenOrbit, plant: Response | None = None) -> SampledLoop:
        """The sampled loop near an orbit.

        Args:
            frozen: Where.
            plant: How the aircraft responds; as the controller is told by default.

        Raises:
            ArithmeticError: The guidance has no answer there.
        """
        plant, period = plant or self.told, 1.0 / self.parameters.control_rate
        predicted = None if self._formulation is None else frozen.dynamics(self.told.lags)
        true = frozen.dynamics(plant.lags)
        return sampled_loop(period, self.gain(frozen), true, plant, predicted, self.told)

    def margins(self, frozen: FrozenOrbit, plant: Response | None = None) -> LoopMargins:
        """Margins of the sampled loop near an orbit; all 0 where it is not stable.

        Args:
            frozen: Where.
            plant: How the aircraft responds; as the controller is told by default.

        Raises:
            ArithmeticError: The guidance has no answer there.
        """
        loop = self.loop(frozen, plant)
        if not loop.growth() < 1.0:
            return UNSTABLE
        frequency = loop.frequencies(FREQUENCIES)
        return loop_margins(frequency, loop.response(frequency))
