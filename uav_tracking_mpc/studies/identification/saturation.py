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

"""Limits of the answer, where it shows them: what is demanded beyond is not flown.

A turn is limited by the bank that it needs, the other channels by the rate itself. On each side the
limit is sought that explains the record best; it counts where it explains it much better than none.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.studies.identification.channel_fit import ChannelFit
from uav_tracking_mpc.studies.identification.channel_record import ChannelRecord

SHARES = np.linspace(0.3, 0.98, 35)  # of the greatest demand, tried as its limit
NEARBY = np.linspace(0.92, 1.08, 17)  # of a limit that was found, tried in its place
ROUNDS = 3  # in which limits and the rest are made to agree
CONVINCING = 30.0  # by which the misfit must fall [-]; by chance it falls by a few


class Limits(NamedTuple):
    """Limits of what is demanded, times its leverage; infinite where none shows.

    Attributes:
        lower: In [rad/s], [m/s^2] or, in a turn, tan(bank) [-].
        upper: In the same unit, [rad/s], [m/s^2] or [-].
    """

    lower: float = -np.inf
    upper: float = np.inf

    def kept(self, record: ChannelRecord) -> NDArray[np.float64]:
        """The demand inside the limits, shape (m,), in [rad/s] or [m/s^2].

        Args:
            record: With the demand.
        """
        lever = record.leverage
        return np.clip(record.demand.value * lever, self.lower, self.upper) / lever


def limited_fit(record: ChannelRecord) -> tuple[ChannelFit, Limits]:
    """The fit of a channel, and the limits that it shows.

    Args:
        record: Of the channel.
    """
    limits = Limits()
    fit = ChannelFit(record, record.demand.value).run()
    for _ in range(ROUNDS):
        found = _better(fit, limits)
        if found == limits:
            break
        limits = found
        fit = ChannelFit(record, limits.kept(record)).run()
    return fit, limits


def _better(fit: ChannelFit, limits: Limits) -> Limits:
    """Limits that explain the record much better than those before, else these.

    Both sides are tried together first: a test signal that is symmetric passes both.
    """
    levered = fit.record.demand.value * fit.record.leverage
    least, most = min(float(np.min(levered)), 0.0), max(float(np.max(levered)), 0.0)
    if limits == Limits():
        limits = _best(fit, limits, [Limits(share * least, share * most) for share in SHARES])
    for side, extreme in (("upper", most), ("lower", least)):
        known = getattr(limits, side)
        places = NEARBY * known if np.isfinite(known) else SHARES * extreme
        limits = _best(fit, limits, [limits._replace(**{side: float(each)}) for each in places])
        without = limits._replace(**{side: getattr(Limits(), side)})
        if _misfit(fit, without) < _misfit(fit, limits) + CONVINCING:
            limits = without
    return limits


def _best(fit: ChannelFit, limits: Limits, tried: list[Limits]) -> Limits:
    """The best of some limits, if it is much better or moves one that is known."""
    misfits = [_misfit(fit, candidate) for candidate in tried]
    best = tried[int(np.argmin(misfits))]
    more = np.isfinite(best).sum() > np.isfinite(limits).sum()
    needed = CONVINCING if more else 0.0
    return best if min(misfits) < _misfit(fit, limits) - needed else limits


def _misfit(fit: ChannelFit, limits: Limits) -> float:
    """Of the same lag, dead time and noise with other limits."""
    other = ChannelFit(fit.record, limits.kept(fit.record))
    other.describe(fit.noise)
    return other.solve(fit.lag, fit.dead_time).misfit
