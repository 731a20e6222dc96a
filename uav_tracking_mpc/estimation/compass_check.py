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

"""Whether a compass turns as the gyros do.

The difference of both, less the gyros' bias, shows a compass that drifts; so do airspeed and wind
(:mod:`~uav_tracking_mpc.estimation.sensor_check`). Without an airspeed the gyros are all that a
heading can be compared with: what it has jumped by is then subtracted.

These are expressions: :mod:`~uav_tracking_mpc.estimation.air_estimate` compiles them.
"""

from __future__ import annotations

import math
from types import SimpleNamespace

import casadi as ca

from uav_tracking_mpc.symbolic.layout import Layout

# rad, rad/s, -, -: a heading jumps if it differs from that of the gyros by more than SNAP, plus
# SNAP_RATE times the time since the last one, plus so many standard deviations of its noise. It is
# right again below a share BACK of SNAP.
SNAP, SNAP_RATE, SNAP_DEVIATIONS, BACK = 0.1, 0.3, 8.0, 0.5
GYRO_TIME = 120.0  # s, memory of the gyros' bias: a compass that drifts is found before
COMPASS_CHECK = Layout(nose=1, snapped=1, rate=1, known_for=1)


def compass_checked(
    known: SimpleNamespace,
    elapsed: ca.SX,
    nose: ca.SX,
    turn: ca.SX,
    alone: ca.SX,
    stuck: ca.SX,
    deviation: ca.SX,
) -> tuple[SimpleNamespace, ca.SX, ca.SX]:
    """What is known after a compass, what it strays by from the gyros, and by what it has jumped.

    The latter two in [rad]: since the compass before, and since it has been right.

    Args:
        known: By :data:`COMPASS_CHECK`: the compass before, by how much it has jumped [rad], how
            quickly it strays from the gyros on average [rad/s], since when that is known [s].
        elapsed: Since the compass before in [s].
        nose: Where the compass says that the nose points, in [rad].
        turn: How it turns by the gyros, as they are measured, in [rad/s].
        alone: Whether no airspeed is used, and the gyros tell the turn.
        stuck: Whether the compass stays the same though the aircraft turns.
        deviation: Standard deviation of the heading's noise in [rad].
    """
    apart = (elapsed > 0.0) * ca.remainder(nose - known.nose - elapsed * turn, math.tau)
    unusual, most = apart - elapsed * known.rate, SNAP_RATE * elapsed
    jumps = ca.logic_or(ca.fabs(unusual) > SNAP + most + SNAP_DEVIATIONS * deviation, stuck)
    known_for = ca.fmin(known.known_for + elapsed, GYRO_TIME)
    # A jump is no bias. What is averaged is kept in bounds, and not what it differs by: else a
    # first noisy compass would stay in the average for minutes.
    learnt = ca.fmax(-most, ca.fmin(apart, most)) - elapsed * known.rate
    change = ca.logic_not(jumps) * ca.if_else(known_for > 0.0, learnt / known_for, 0.0)
    strayed = unusual - elapsed * change
    snapped = alone * ca.remainder(known.snapped + jumps * strayed, math.tau)
    after = SimpleNamespace(
        nose=nose, snapped=snapped, rate=known.rate + change, known_for=known_for
    )
    return after, strayed, snapped
