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

"""Section 6 as the paper ran it: the prediction model itself, by Euler's method, is flown."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from uav_tracking_mpc.dynamics.frames import wrap_angle
from uav_tracking_mpc.dynamics.relative import rates_function, relative_state, vehicle_state
from uav_tracking_mpc.dynamics.vehicle import velocity
from uav_tracking_mpc.estimation.measurement import Measurement
from uav_tracking_mpc.settings.configuration import Configuration
from uav_tracking_mpc.settings.simulator import SimulatorParameters
from uav_tracking_mpc.simulation.plants import Plant, SimulationError


class EulerPlant(Plant):
    """xbar+ = xbar + T_s f(xbar, u), (10), about a target that stands, as (9) demands.

    It has one command a step T_s, no limits of its own, still air and no lag.

    Args:
        parameters: Where it starts.
        model: Prediction model that gives the rates f.
        step: T_s in [s].
        target: Position in ``map``, shape (3,), in [m].

    Raises:
        SimulationError: It starts straight above or below the target.
    """

    name = "euler"

    def __init__(
        self,
        parameters: SimulatorParameters,
        model: str = "exact",
        step: float = 1.0,
        target: ArrayLike = (0.0, 0.0, 0.0),
    ) -> None:
        super().__init__(parameters)
        self.period = step
        self._rates = rates_function(model)
        self._target = np.array(target, dtype=float)
        self._relative = relative_state(parameters.initial_state, self._target)
        self._heading = parameters.initial_heading
        self._inputs = np.zeros(3)
        self._check()

    @classmethod
    def of(cls, configuration: Configuration) -> EulerPlant:
        """See :meth:`Plant.of`.

        Raises:
            SimulationError: The target moves, there is wind, or a step is longer than a target
                counts.
        """
        tracking, target = configuration.controller, configuration.target
        simulator = configuration.simulator
        still = {
            "'motion' of target_publisher": (target.motion, "stationary"),
            "'wind' of uav_simulator": (list(simulator.wind), [0.0, 0.0, 0.0]),
            "'gust_intensity' of uav_simulator": (simulator.gust_intensity, 0.0),
        }
        for name, (value, allowed) in still.items():
            if value != allowed:
                raise SimulationError(
                    f"parameter {name} is {value!r}, must be {allowed!r} on the Euler plant; fly "
                    "the vehicle with --set mission.plant=vehicle"
                )
        if tracking.horizon_step > tracking.target_timeout:
            raise SimulationError(
                f"parameter 'target_timeout' of nmpc_controller is {tracking.target_timeout:g} s, "
                f"must be at least 'horizon_step', {tracking.horizon_step:g} s, on the Euler plant"
            )
        return cls(simulator, tracking.model, tracking.horizon_step, target.position)

    def advance(self, duration: float) -> None:
        """See :meth:`Plant.advance`."""
        if duration <= 0.0:
            return
        plan = self.plan.inputs(self.time)
        self._inputs = np.zeros(3) if plan is None else plan
        turn_rate, *_ = self._inputs.tolist()
        rates = np.array(self._rates(self._relative, self._inputs)).ravel()
        range_, bearing, altitude, path_angle, speed = self._relative + duration * rates  # (10)
        self._relative = np.array([range_, wrap_angle(bearing), altitude, path_angle, speed])
        self._heading += duration * turn_rate
        self.time += duration
        self._check()

    def _check(self) -> None:
        range_, _, altitude, _, _ = self._relative.tolist()
        if not range_ > abs(altitude):
            raise SimulationError(
                f"at {self.time:g} s the range is {range_:.6g} m at a height of {altitude:.6g} m: "
                "the Euler plant has no value there; fly the vehicle with "
                "--set mission.plant=vehicle"
            )

    @property
    def state(self) -> NDArray[np.float64]:
        """(x, y, z, psi, chi, v) with the relative state and the heading, shape (6,)."""
        _, bearing, *_ = self._relative.tolist()
        return vehicle_state(self._relative, self._heading - bearing - np.pi, self._target)  # (4)

    @property
    def truth(self) -> Measurement:
        """See :meth:`Plant.truth`."""
        state = self.state
        *position, heading, path_angle, airspeed = state.tolist()
        turn_rate, path_angle_rate, _ = self._inputs.tolist()
        return Measurement(
            stamp=self.time,
            position=np.array(position),
            ground_velocity=velocity(state),
            heading=heading,
            path_angle=path_angle,
            turn_rate=turn_rate,
            path_angle_rate=path_angle_rate,
            airspeed=airspeed,
        )
