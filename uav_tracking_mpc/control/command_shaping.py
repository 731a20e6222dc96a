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

"""Commands inside their limits, without a jump where one kind of guidance takes over from another.

What is sent is what is wanted plus an offset that always decays. Where what is wanted jumps, since
another kind of guidance or other parameters are flown, the offset takes up the jump: the command
goes on from where it was, and converges to what is wanted however often that changes.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.control.event import EventLog
from uav_tracking_mpc.control.excitation import Excitation
from uav_tracking_mpc.control.fallback import FallbackMode
from uav_tracking_mpc.settings.tracking import TrackingParameters

# s, time constant of the offset that a change leaves. Changes with every command make it a lag in
# the loop, which must stay below the delay margin that is asked for by default.
FADE_TIME = 0.25
TURN = 0  # axis of u_psi among the inputs


class CommandShaper:
    """Clips commands and keeps them from jumping.

    Args:
        parameters: Limits of the inputs and of the bank, and the excitation.
        events: Where the excitation is reported.

    Attributes:
        excitation: The test signal that is added to what is shaped.
    """

    def __init__(self, parameters: TrackingParameters, events: EventLog) -> None:
        self.excitation = Excitation(parameters, events)
        self.change(parameters)
        self.reset()

    def change(self, parameters: TrackingParameters) -> None:
        """Use other limits from now on.

        The offset takes up the difference: a wider orbit would begin at the bank limit.

        Args:
            parameters: The new ones.
        """
        self._envelope = parameters.envelope
        self._lower, self._upper = parameters.input_lower, parameters.input_upper
        self._changed = True
        self.excitation.change(parameters)

    def reset(self) -> None:
        """Forget what was commanded: the next command comes as it is."""
        self._wanted: NDArray[np.float64] | None = None
        self._mode = FallbackMode.SILENCE
        self._offset, self._time = np.zeros(3), 0.0
        self._changed = False
        self.excitation.reset()

    def shape(
        self,
        time: float,
        inputs: NDArray[np.float64],
        step: float,
        airspeed: float,
        mode: FallbackMode,
    ) -> NDArray[np.float64]:
        """Inputs to be sent.

        Args:
            time: From which on they count, in [s].
            inputs: (u_psi, u_chi, u_v) at time, time + step, ..., shape (n, 3).
            step: In [s].
            airspeed: v in [m/s], which with the bank limits the turn rate.
            mode: Where the inputs come from.

        Returns:
            Finite inputs inside their limits, shape (n, 3).
        """
        if math.isfinite(airspeed):
            self._upper[TURN] = self._envelope.turn_rate_max(airspeed)
            self._lower[TURN] = -self._upper[TURN]
        inside = self._clipped(inputs)
        other = mode is not self._mode and not (mode.planned and self._mode.planned)
        self._offset *= math.exp(-max(0.0, time - self._time) / FADE_TIME)
        if self._wanted is not None and (other or self._changed):
            self._offset += self._wanted - inside[0]
        self._wanted, self._time, self._mode, self._changed = inside[0], time, mode, False
        if not self._offset.any():
            return inside
        share = np.exp(-step / FADE_TIME * np.arange(len(inside)))
        return self._clipped(inside + share[:, np.newaxis] * self._offset)

    def _clipped(self, inputs: NDArray[np.float64]) -> NDArray[np.float64]:
        """Inputs inside their limits; what is not finite becomes 0."""
        finite = np.isfinite(inputs)
        if not finite.all():
            inputs = np.where(finite, inputs, 0.0)
        return np.minimum(np.maximum(inputs, self._lower), self._upper)
