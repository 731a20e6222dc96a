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

r"""Direction of flight through the air from the attitude: the nose without its swing.

An autopilot tells where the nose points. In a roll the nose swings to the side (adverse yaw,
rudder, Dutch roll), while the aircraft turns as its bank says. A controller that took the swing for
a turn would answer it, against the phase, with a limit cycle. Quick changes are therefore those of
the bank, slow ones those of the nose, by a complementary filter (e.g. Mahony, Hamel, Pflimlin, IEEE
Trans. Automatic Control 53(5), 2008):

.. math::

    \dot\beta = r_n - r_b - b - 2 \omega \beta, \quad \dot b = \omega^2 \beta, \quad
    \psi = \psi_n - \beta, \quad \dot\psi = r_b + b + 2 \omega \beta

with the nose at :math:`\psi_n`, its rate :math:`r_n`, the rate :math:`r_b = -g \tan\phi / v` of a
coordinated turn, and the swing :math:`\beta`. An aircraft that slips in a steady turn turns at
another rate than that of its bank, by b; this shows slowly, and is to be taken out as slowly: in a
quick roll the bank still counts in full.

Up and down there is no such second source: in turbulence the nose's pitch rate is mostly that of
the gusts and of the autopilot's answer to them. The measured climb :math:`w_m` is followed instead,
by a filter of second order, which a steady change passes without an error:

.. math::

    \dot w = a + 2 \omega_w (w_m - w), \quad \dot a = \omega_w^2 (w_m - w)
"""

from __future__ import annotations

import math

FREQUENCY = 0.3  # rad/s, omega: well below the swing's, which is some rad/s
LONGEST_STEP = 0.5  # s between attitudes, after which the filter begins anew
SURPLUS_LIMIT = 0.15  # rad/s, of a turn's surplus over its bank


class FlightDirection:
    """Follows one aircraft's attitude.

    Attributes:
        heading: psi, counter-clockwise from East, in [rad].
        rate: psi' in [rad/s].
        surplus: b, what the turn rate exceeds that of a coordinated turn by, in [rad/s].
    """

    def __init__(self) -> None:
        self.heading = self.rate = self.surplus = 0.0
        self._swing = 0.0
        self._time: float | None = None

    def see(self, time: float, nose: float, nose_rate: float, bank_rate: float | None) -> None:
        """Take in an attitude.

        Args:
            time: Of the attitude in [s].
            nose: Where the nose points, counter-clockwise from East, in [rad].
            nose_rate: Its rate in [rad/s].
            bank_rate: Rate of a coordinated turn at the same bank in [rad/s]; None where the
                airspeed is unknown, and the nose counts.
        """
        if bank_rate is None:
            self._time, self.surplus = None, 0.0
            self.heading, self.rate = nose, nose_rate
            return
        step = math.inf if self._time is None else time - self._time
        self._time = time
        if 0.0 < step <= LONGEST_STEP:
            turn_rate = bank_rate + self.surplus + 2.0 * FREQUENCY * self._swing
            self._surpass(self.surplus + step * FREQUENCY**2 * self._swing)
            self._swing += step * (nose_rate - turn_rate)
        elif step != 0.0:
            self._swing = 0.0
            self._surpass(nose_rate - bank_rate)
        self.heading = nose - self._swing
        self.rate = bank_rate + self.surplus + 2.0 * FREQUENCY * self._swing

    def _surpass(self, surplus: float) -> None:
        self.surplus = min(max(surplus, -SURPLUS_LIMIT), SURPLUS_LIMIT)


class Climb:
    """Follows one aircraft's climb.

    Attributes:
        value: w, positive up, in [m/s].
        rate: a in [m/s^2].
    """

    def __init__(self) -> None:
        self.value = self.rate = 0.0
        self._time = -math.inf

    def see(self, time: float, measured: float, frequency: float) -> None:
        """Take in a climb.

        Args:
            time: Of the measurement in [s].
            measured: Positive up, in [m/s].
            frequency: omega_w in [rad/s].
        """
        step, self._time = time - self._time, time
        if not 0.0 < step <= LONGEST_STEP:
            self.value, self.rate = measured, 0.0
            return
        # The solution for a measurement that stands still during the step.
        faded, error = math.exp(-frequency * step), self.value - measured
        slope = self.rate - frequency * error
        error += step * slope
        self.value = measured + faded * error
        self.rate = faded * (slope + frequency * error)
