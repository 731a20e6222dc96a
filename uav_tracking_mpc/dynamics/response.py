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

"""How an aircraft answers commands of turn rate, path-angle rate and acceleration."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray


class Response(NamedTuple):
    """A first-order lag behind a dead time on each of the three channels.

    Attributes:
        lags: Time constants, shape (3,), in [s].
        dead_times: Shape (3,), in [s].
        gains: What is flown over what is commanded, shape (3,) [-].
    """

    lags: NDArray[np.float64]
    dead_times: NDArray[np.float64]
    gains: NDArray[np.float64]
