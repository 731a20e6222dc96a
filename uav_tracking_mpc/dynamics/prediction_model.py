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

"""What every prediction model says: its name, its state, and where a measurement puts it."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any, ClassVar

from numpy.typing import ArrayLike


class PredictionModel(ABC):
    """Base of the relative models (rates) and of the models of the vehicle (steps).

    Attributes:
        name: By which it is found.
        State: NamedTuple of the state's components.
    """

    name: ClassVar[str]
    State: ClassVar[Any]

    @abstractmethod
    def initial(self, vehicle: ArrayLike, target: ArrayLike, rates: ArrayLike) -> Any:
        """State of a measured motion, a ``State`` of floats.

        Args:
            vehicle: (x, y, z, psi, chi, v) in ``map``, shape (6,).
            target: Position in ``map``, shape (3,), in [m].
            rates: (psi', chi', v'), shape (3,), in [rad/s, rad/s, m/s^2].
        """
