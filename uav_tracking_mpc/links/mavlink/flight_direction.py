r"""Direction of flight through the air from the attitude: the nose without its swing.

An autopilot tells where the nose points. In a roll the nose swings to the side (adverse yaw,
rudder, Dutch roll), while the aircraft turns as its bank says. A controller that took the swing for
a turn would answer it, against the phase, with a limit cycle. Quick changes are therefore those of
the bank, slow ones those of the nose, by a complementary filter (e.g. Mahony, Hamel, Pflimlin, IEEE
Trans. Automatic Control 53(5), 2008):

.. math::

    \dot\beta = r_n - k r_b - b - 2 \omega \beta, \quad \dot b = \omega^2 \beta, \quad
    \psi = \psi_n - \beta, \quad \dot\psi = k r_b + b + 2 \omega \beta

with the nose at :math:`\psi_n`, its rate :math:`r_n`, the rate :math:`r_b = -g \tan\phi / v` of a
coordinated turn, the swing :math:`\beta` and a bias b. An aircraft that slips turns by another
share k of that rate; k is the least-squares ratio of both rates, smoothed and forgotten
exponentially, and b takes up its changes so that :math:`\dot\psi` has no steps.
"""

from __future__ import annotations

import math

FREQUENCY = 0.3  # rad/s, omega: well below the swing's, which is some rad/s
LONGEST_STEP = 0.5  # s between attitudes, after which the filter begins anew
SMOOTHING, MEMORY = 1.0, 20.0  # s, of the rates that k is the ratio of, and of k
PRIOR = 0.01**2  # rad^2/s^2, mean square of the turn rate that counts as much as k = 1
SHARES = 0.6, 1.3  # k, at least and at most


class FlightDirection:
    """Follows one aircraft's attitude.

    Attributes:
        heading: psi, counter-clockwise from East, in [rad].
        rate: psi' in [rad/s].
        share: k, turn rate over that of a coordinated turn at the same bank [-].
    """

    def __init__(self) -> None:
        self.heading = self.rate = 0.0
        self.share = 1.0
        self.reset()

    def reset(self) -> None:
        """Begin anew: at first the nose points where the aircraft flies."""
        self._time: float | None = None
        self._swing = self._bias = self._nose_rate = self._bank_rate = 0.0
        self._product, self._power = PRIOR * MEMORY, PRIOR * MEMORY

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
            self._time = None
            self.heading, self.rate = nose, nose_rate
            return
        step = math.inf if self._time is None else time - self._time
        self._time = time
        if 0.0 < step <= LONGEST_STEP:
            self._learn(step, nose_rate, bank_rate)
            by_bank = self.share * bank_rate + self._bias + 2.0 * FREQUENCY * self._swing
            self._bias += step * FREQUENCY**2 * self._swing
            self._swing += step * (nose_rate - by_bank)
        elif step != 0.0:
            self._swing, self._bias = 0.0, nose_rate - self.share * bank_rate
            self._nose_rate, self._bank_rate = nose_rate, bank_rate
        self.heading = nose - self._swing
        self.rate = self.share * bank_rate + self._bias + 2.0 * FREQUENCY * self._swing

    def _learn(self, step: float, nose_rate: float, bank_rate: float) -> None:
        """Follow k."""
        new, kept = 1.0 - math.exp(-step / SMOOTHING), math.exp(-step / MEMORY)
        self._nose_rate += new * (nose_rate - self._nose_rate)
        self._bank_rate += new * (bank_rate - self._bank_rate)
        prior = PRIOR * MEMORY * (1.0 - kept)
        self._product = kept * self._product + step * self._nose_rate * self._bank_rate + prior
        self._power = kept * self._power + step * self._bank_rate**2 + prior
        least, most = SHARES
        before, self.share = self.share, min(max(self._product / self._power, least), most)
        self._bias += (before - self.share) * bank_rate
