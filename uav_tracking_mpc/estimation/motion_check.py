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

r"""Which ground velocities and positions are believed: each is compared with what the others tell.

- A **ground velocity** far from what is expected is left out, unless within a second the positions
  say that it was flown and what was expected was not: then the air has changed.
- A **position** far from where the ground velocity leads is left out for a time; if the next ones
  stay there, that is where the aircraft is. One that repeats is none.

These are expressions: :mod:`~uav_tracking_mpc.estimation.air_estimate` compiles them.
"""

from __future__ import annotations

import math
from types import SimpleNamespace

import casadi as ca

from uav_tracking_mpc.estimation.sensor_health import CODE, JUMPED, SILENT, STUCK
from uav_tracking_mpc.estimation.state_gate import NOISE_MULTIPLE, STEEPEST, SUDDEN
from uav_tracking_mpc.symbolic.layout import Layout

DEVIATIONS = 4.0  # -, standard deviations that gusts explain
RETURN = 0.5  # -, share of its limits that what was left out must keep to before it counts again

# Ground velocity
ODD = 10.0  # m/s, beyond gusts: a ground velocity that differs by more from the expected is odd
# s, least length of a window, at whose end positions tell which velocity was flown; and for which a
# reading that is stuck stays the same
WINDOW = 1.0
# m/s, s: positions contradict a velocity if the way flown differs from it by more than CONTRARY,
# besides the noise of positions, for CONTRARY_TIME: a position that jumps and comes back takes two
# windows
CONTRARY, CONTRARY_TIME = 3.0, 3.0
ALIKE = 0.5  # -, least cosine between the differences of two windows: those of jumps go anywhere
# m/s, -: least climb of a window in which height and climb are compared; how many windows count
CLIMBING, CLIMBS = 0.3, 20.0
# m^2, -, -: of the sum of the climbs' squares, what it must exceed, and by how many variances of
# the height; and the share of it below which the heights go against the climb
LEAST_CLIMB, SURE_CLIMB, AGAINST = 1.0, 70.0, -0.3
VELOCITY_CHECK = Layout(
    odd=1, time=1, begin=3, way=3, by_expected=3, before=3, error=3, contrary=1, climbs=2
)

# m, s, s: a position that is off by more than JUMP, besides its noise, is left out. If positions
# stay there for JUMP_TIME, the aircraft is there, and its place is moved there with FADE_TIME.
JUMP, JUMP_TIME, FADE_TIME = 2.0, 2.0, 10.0
# m, s: one that is further off contradicts all other sensors: a receiver without a fix, or the
# filter of an autopilot that was astray. It must stay there for FAR_TIME, and tells nothing of the
# ground velocity until then. A height that is so much too great is never followed: it would lead to
# the ground.
FAR, FAR_TIME = 30.0, 30.0
# m/s: how quickly one that is carried on goes astray, by the ground velocity, and by air velocity
# and wind. A position that is off by no more than DEVIATIONS times that is where the aircraft is.
ASTRAY, BY_WIND = 0.3, 1.5
STALE = 1.5  # s, for which a position may repeat itself that is only seldom measured
STANDING = 0.25  # -, share of JUMP, beyond which a climb leaves out a height that stays the same
POSITION_CHECK = Layout(jumped=1, age=1, off=3, faded=3, last=[math.nan] * 3, climbed=1, astray=1)


def velocity_checked(
    known: SimpleNamespace,
    elapsed: ca.SX,
    position: ca.SX,
    fresh: ca.SX,
    measured: ca.SX,
    expected: ca.SX,
    deviation: ca.SX,
    noise: ca.SX,
) -> tuple[SimpleNamespace, ca.SX, ca.SX, ca.SX]:
    """What is known after a ground velocity; is it odd, contradicted, or has the air changed.

    The air has changed if one was odd for a window, in which it was flown rather than what was
    expected. Positions contradict one if in :data:`CONTRARY_TIME` of windows the way flown differs,
    to the same side. Positions that fail do so for a moment, or repeat themselves. A vertical
    velocity of the other sign differs by little at first, and the more the aircraft is steered by
    it: they contradict one as well if heights mostly change against it.

    Args:
        known: By :data:`VELOCITY_CHECK`: whether the velocity is odd, for how long this window
            lasts [s], where it began, the ways by both velocities since then [m], the velocity
            before [m/s], by how much the way of the window before differed [m], for how long
            windows have contradicted the velocity [s], sums over windows of c h and c^2, with the
            climb c and as much of the height's h [m^2].
        elapsed: Since the measurement before in [s].
        position: As measured, shape (3,), in [m].
        fresh: 1 where one is measured that is not the one before, else 0.
        measured: Shape (3,), in [m/s].
        expected: Shape (3,), in [m/s].
        deviation: Standard deviation of the difference of both velocities in [m/s].
        noise: Standard deviation of the noise of positions on the worst axis in [m].
    """
    # Gusts explain what comes by and by, not what comes between two measurements.
    sudden = ca.norm_2(measured - known.before) > SUDDEN + STEEPEST * elapsed
    explained = ca.if_else(ca.logic_or(sudden, known.odd), 0.0, DEVIATIONS * deviation)
    far = ca.norm_2(measured - expected) > ODD + explained
    time, way = known.time + elapsed, known.way + 0.5 * elapsed * (known.before + measured)
    by_expected = known.by_expected + elapsed * expected
    flown = position - known.begin
    difference = flown - way
    difference[2] *= flown[2] != 0.0  # a height that stays the same is judged by itself
    error, error_before = ca.norm_2(difference), ca.norm_2(known.error)
    limit = CONTRARY * time + NOISE_MULTIPLE * noise
    # Where nothing is odd yet, a window lasts until noise is the lesser part of what it allows.
    seen = ca.logic_or(ca.logic_or(far, error > limit), CONTRARY * time >= NOISE_MULTIPLE * noise)
    full = fresh * (time >= WINDOW) * seen
    changed = full * far * known.odd * (error < ca.norm_2(flown - by_expected))
    along = ca.dot(difference, known.error) > ALIKE * error * error_before
    kept = ca.logic_and(known.contrary >= CONTRARY_TIME, error > RETURN * limit)
    contrary = ca.fmin(ca.if_else(along, known.contrary, 0.0) + WINDOW, CONTRARY_TIME)
    contrary = ca.if_else(error > limit, contrary, 0.0)
    contrary = ca.if_else(kept, known.contrary, contrary)
    climb, most = way[2], ca.fabs(way[2])
    height = ca.fmin(ca.fmax(flown[2], -most), most)
    climbs = math.exp(-1.0 / CLIMBS) * known.climbs + climb * ca.vertcat(height, climb)
    climbs = ca.if_else(full * (most > CLIMBING * time), climbs, known.climbs)
    sure = climbs[1] > LEAST_CLIMB + SURE_CLIMB * noise**2
    against = sure * (climbs[0] < AGAINST * climbs[1])
    begins = ca.logic_or(full, ca.logic_and(far, ca.logic_not(known.odd)))
    after = SimpleNamespace(
        odd=ca.logic_and(far, ca.logic_not(changed)),
        time=ca.if_else(begins, 0.0, time),
        begin=ca.if_else(begins, position, known.begin),
        way=ca.if_else(begins, 0.0, way),
        by_expected=ca.if_else(begins, 0.0, by_expected),
        before=measured,
        error=ca.if_else(full, difference, known.error),
        contrary=ca.if_else(full, contrary, known.contrary),
        climbs=climbs,
    )
    return after, after.odd, ca.logic_or(after.contrary >= CONTRARY_TIME, against), changed


def is_fresh(known: SimpleNamespace, position: ca.SX, present: ca.SX) -> ca.SX:
    """Whether a position in [m] is measured that is not the last one in ``known``.

    A barometer tells a new height beside a place that its receiver repeats.
    """
    return present * (ca.sumsqr((position - known.last)[:2]) > 0.0)


def is_far(known: SimpleNamespace) -> ca.SX:
    """Whether positions in ``known`` have jumped so far that they tell no velocity."""
    return ca.logic_and(known.jumped > 0.0, ca.norm_2(known.off) > FAR)


def position_checked(
    known: SimpleNamespace,
    elapsed: ca.SX,
    position: ca.SX,
    present: ca.SX,
    carried: ca.SX,
    climb: ca.SX,
    deviation: ca.SX,
    odd: ca.SX,
) -> tuple[SimpleNamespace, ca.SX, ca.SX, ca.SX, ca.SX, ca.SX]:
    """What is known after a position, its state by :data:`CODE`, and what of it is used.

    Then on which axes it is the measured one, shape (3,), whether it jumps, and whether positions
    scatter: one after the other is far off, each elsewhere, so that their noise must have grown.

    Args:
        known: By :data:`POSITION_CHECK`: for how long positions have been elsewhere [s], how long
            ago the last one was measured [s], how far it was from where the velocity leads [m],
            what of a jump is still to be told [m], the last position [m], how far the aircraft has
            climbed since the height changed last [m], by how much it may have gone astray [m].
        elapsed: Since the measurement before in [s].
        position: As measured, shape (3,), in [m].
        present: 1 where one is measured, else 0.
        carried: Where the ground velocity leads, shape (3,), in [m].
        climb: Upward ground velocity in [m/s].
        deviation: Standard deviation of the noise on the worst axis in [m].
        odd: Whether the ground velocity is not the measured one.
    """
    limit = JUMP + NOISE_MULTIPLE * deviation
    fresh = is_fresh(known, position, present)
    age = ca.if_else(fresh, 0.0, known.age + elapsed)
    # A height that comes again with its position tells nothing, but one beside a new place does.
    stands = position[2] == known.last[2]
    goes_on = ca.fabs(known.climbed) <= limit  # and then stays beyond
    climbed = stands * (known.climbed + goes_on * (known.age + elapsed) * climb)
    climbed = ca.if_else(fresh, climbed, known.climbed)
    level = ca.fabs(climbed) > limit
    # Long before, or the filter would take what the height does not show for the velocity's bias.
    old = ca.fabs(climbed) > STANDING * limit
    place = ca.vertcat(position[:2], ca.if_else(old, carried[2], position[2]))
    off = place - carried
    far = ca.logic_and(present, ca.norm_2(off) > limit)
    scattered = far * fresh * (known.jumped > 0.0) * (ca.norm_2(off - known.off) > limit)
    # Positions that come seldom repeat themselves, or are absent, between two that are measured.
    stale = age > STALE
    lasts = ca.if_else(fresh, far, known.jumped > 0.0)
    jumped = ca.if_else(lasts, (1.0 - scattered) * known.jumped + elapsed, known.jumped * old)
    straying = ca.if_else(odd, BY_WIND, ASTRAY)  # what it has done since does not count
    strayed = ca.norm_2(off) <= DEVIATIONS * (known.astray - straying * known.jumped)
    lasting = ca.if_else(ca.norm_2(off) > FAR, FAR_TIME, JUMP_TIME)
    lasting = ca.if_else(off[2] > FAR, ca.inf, lasting)
    moved = ca.logic_and(far * fresh, ca.logic_or(jumped >= lasting, strayed))
    waits = lasts * ca.logic_not(moved) * ca.logic_not(stale)
    silent = ca.logic_not(present) * stale
    stuck = ca.logic_or(far * ca.logic_not(fresh) * stale, level) * ca.logic_not(
        ca.logic_or(waits, silent)
    )
    code = CODE[JUMPED] * waits + CODE[STUCK] * stuck + CODE[SILENT] * silent
    after = SimpleNamespace(
        jumped=ca.if_else(moved, 0.0, jumped),
        age=age,
        off=ca.if_else(fresh, off, known.off),
        faded=known.faded * ca.exp(-elapsed / FADE_TIME) - moved * (1.0 - strayed) * off,
        last=ca.if_else(present, position, known.last),
        climbed=climbed,
        astray=(code > 0.0) * (known.astray + elapsed * straying),
    )
    seen_axes = fresh * ca.logic_not(waits) * ca.vertcat(1.0, 1.0, ca.logic_not(old))
    return after, code, ca.if_else(seen_axes, position, carried), seen_axes, moved, scattered
