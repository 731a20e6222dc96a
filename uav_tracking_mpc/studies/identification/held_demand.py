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

r"""A rate behind a first-order lag and a dead time, exact for demands held from step to step.

.. math:: \tau \dot\omega(t) = u(t - D) - \omega(t), \qquad
          \int \omega = \int u(t - D) - \tau \omega(t) + \mathrm{const}

The second one follows from the first and needs no integration of its own. A dead time moves the
response as a whole, so that the rates at the steps belong to the lag alone.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.studies.identification.channel_record import Samples


class HeldDemand:
    """A demand that is held from each of its steps to the next.

    Args:
        demand: Its steps.
    """

    def __init__(self, demand: Samples) -> None:
        self._time, self._value = demand
        durations = np.diff(self._time)
        self._durations = durations
        self._integral = np.concatenate([[0.0], np.cumsum(self._value[:-1] * durations)])

    def rates_at_steps(self, lag: float) -> NDArray[np.float64]:
        """Rate at each step without dead time, shape (m,); at the first it is what is demanded.

        Args:
            lag: tau in [s].
        """
        left = np.exp(-self._durations / lag) if lag > 0.0 else np.zeros(len(self._durations))
        factors = np.concatenate([[0.0], left])
        rates = np.concatenate([self._value[:1], self._value[:-1] * (1.0 - left)])
        # x_k = a_k x_(k-1) + b_k for all k at once: the maps are composed over 1, 2, 4, ... steps.
        reach = 1
        while reach < len(rates):
            rates[reach:] = rates[reach:] + factors[reach:] * rates[:-reach]
            factors[reach:] = factors[reach:] * factors[:-reach]
            reach *= 2
        return rates

    def response(
        self, time: NDArray[np.float64], lag: float, dead_time: float, rates: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Rate and its integral, but for a constant, each of the shape of the times.

        Args:
            time: Not before the first demand, in [s], shape (n,).
            lag: tau in [s].
            dead_time: D in [s].
            rates: As of :meth:`rates_at_steps` for this lag, shape (m,).
        """
        shifted = time - dead_time
        step = np.searchsorted(self._time, shifted, side="right") - 1
        step = np.maximum(step, 0)
        since = np.maximum(shifted - self._time[step], 0.0)
        demanded = self._value[step]
        rate = demanded
        if lag > 0.0:
            rate = demanded + (rates[step] - demanded) * np.exp(-since / lag)
        return rate, self._integral[step] + demanded * since - lag * rate
