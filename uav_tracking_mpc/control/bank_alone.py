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

"""A guidance law whose turn rate alone is flown: the autopilot holds altitude and airspeed."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.dynamics.vehicle_models import VehicleModel
from uav_tracking_mpc.estimation.situation import Situation
from uav_tracking_mpc.laws import GuidanceLaw


class BankAlone(GuidanceLaw):
    """A law, with what the autopilot finds itself in the place of its other inputs.

    Args:
        law: Whose turn rate is flown.
        model: Of the aircraft, which says what the autopilot finds itself.
    """

    def __init__(self, law: GuidanceLaw, model: VehicleModel) -> None:
        super().__init__(law.orbit, law.envelope)
        self.name = law.name  # type: ignore[misc]  # errors are told by the name of the law
        self._law, self._model = law, model
        self._numbers = model.numbers(1.0)  # none of those of what is held depends on the step

    def inputs(self, situation: Situation) -> NDArray[np.float64]:
        """See :meth:`GuidanceLaw.inputs`; the envelope has no say in what the autopilot finds."""
        state = self._model.initial(situation.vehicle, situation.target, situation.rates)
        held = self._model.held(
            state, self.orbit.altitude, self.orbit.speed, self._numbers, situation.drift
        )
        inputs = np.array(self._law.inputs(situation), dtype=float)
        inputs[self._model.commanded :] = held
        return inputs
