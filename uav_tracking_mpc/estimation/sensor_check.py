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

r"""Which of position, ground velocity, airspeed and heading are believed.

Each is compared with what the others tell:

- a **ground velocity** far from what is expected is left out, unless within a second the positions
  say that it was flown and what was expected was not: then the air has changed;
- a **position** far from where the ground velocity leads is left out for a time; if the next ones
  stay there, that is where the aircraft is. One that repeats is none;
- **airspeed and heading** are compared with the wind triangle. With the ground velocity
  :math:`v_g` and the mean wind w, the velocity through the air is :math:`u = v_g - w`. It is to be
  as fast as the airspeed, and to point along the heading:

.. math:: r = v - |u|, \qquad c = |u| \angle(\psi, u) .

Each of these two sensors is judged by a wind that was found without it. By that wind a sensor that
fails shows on its own residual alone, while gusts and a wind that changes show on both as the
aircraft turns. A sensor is left out when its residual has jumped within a few seconds, or has
stayed away from zero for longer, by more than the other residual and the change of that wind
explain: a wind that has changed where it is seen may have changed where it is not. To have jumped
it must itself have changed otherwise than the aircraft is accelerated or turns: where that is what
the ground velocity has done, the air has changed. An airspeed that
stays the same to the last bit though the aircraft has been accelerated is left out too. Ground
velocity and wind stand in for a sensor until it agrees again.

These are expressions: :mod:`~uav_tracking_mpc.estimation.air_estimate` compiles them.
"""

from __future__ import annotations

import math
from types import SimpleNamespace

import casadi as ca

from uav_tracking_mpc.estimation.sensor_health import JUMPED, OFF, SILENT, STATES, STUCK, USED
from uav_tracking_mpc.estimation.state_gate import NOISE_MULTIPLE
from uav_tracking_mpc.symbolic.layout import Layout

CODE = {state: float(number) for number, state in enumerate(STATES)}

# Ground velocity
ODD = 10.0  # m/s, beyond gusts: a ground velocity that differs by more from the expected is odd
SUDDEN, STEEPEST = 5.0, 30.0  # m/s, m/s^2: a change beyond SUDDEN + STEEPEST times is no gust's
WINDOW = 1.0  # s, length of a window, at whose end positions tell which velocity was flown
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
STALE = 1.5  # s, for which a position may repeat itself that is only seldom measured
STANDING = 0.25  # -, share of JUMP, beyond which a climb leaves out a height that stays the same
POSITION_CHECK = Layout(jumped=1, age=1, off=3, faded=3, last=[math.nan] * 3, climbed=1)

# Airspeed and heading
# s: time constants of the noise of a residual, of its jumps, and of what lasts
SMOOTHING, CHANGE_TIME, LASTING = 0.7, 4.0, 7.0
LEAST_JUMP, LEAST_OFFSET = 1.0, 0.8  # m/s, that a jump, and what lasts, must exceed in still air
GATE = 4.0  # m/s, besides gusts: an airspeed that is further off is left out at once
# -, how many standard deviations of the other residual, and of its own, gusts explain. Those along
# a real aircraft show as airspeed before they move it, those across it hardly.
DEVIATIONS, OWN_DEVIATIONS = 4.0, 3.0
DOMINANCE = 3.0  # -, least ratio of the residual of a sensor that fails to the other one
# rad, that the error of a wind turns against the heading during a jump: of the wind without
# airspeed, and of that without heading. With 0.3 of both a sound heading was blamed in gusts.
TURNED = 0.3, 0.7
# s: by what the wind without airspeed has changed in this time, it may also have changed along the
# heading, where it is not seen
CHANGES = 40.0
# m/s: standard deviation of the wind above which nothing is compared; and late in a flight, when
# gusts let no wind be known better
WIND_KNOWN, WIND_IN_GUSTS = 1.5, 2.5
COMPARED = 60.0  # s, memory of the gusts
PRIOR, PRIOR_TIME = 0.5, 3.0  # m/s, s: gusts that are taken at first, and the weight of that
# -, share of a jump that is the sensor's own: above the one it is named, below the other it is used
OWN_SHARE, LEAST_SHARE = 0.5, 0.25
DOUBT = 1.5  # m/s, by which a sound airspeed may read otherwise than the wind explains
# -, s: a sensor is used again once it has kept to this share of its limits for this time
AGREEING, AGREED_FOR = 0.5, 5.0
# m/s, rad: least speed through the air that tells a heading; the greatest difference of headings
FLYING, HALF_TURN = 1.0, math.pi + 0.5
STUCK_FOR, STUCK_CHANGE = 1.0, 0.4  # s and m/s: of a reading, and of the speed meanwhile
# -, m/s: the same where nothing is commanded: a reading stands so many times as long as usual, and
# the speed changes by more than the steps of a coarse one
LONGER, UNTOLD_CHANGE = 10.0, 0.6
AIRSPEED, HEADING = 0, 1  # indices of the sensors
ITS, OTHER = [0, 3], [1, 2]  # indices of residuals: of each sensor, and the other one by that wind
# Residuals (r, c) in m/s by the wind without airspeed, then by that without heading: without noise,
# as of some seconds ago, and what lasts; and mean squares of what gusts make of them. Of both
# sensors' own changes in m/s what is taken for noise so far, what is a jump, what lasts. By how
# much in m/s an airspeed may be too high, and too low, that nobody has found wrong yet; and which
# part of what lasts nothing else explains.
AIR_CHECK = Layout(
    reasons=2, agreed=2, now=4, before=4, lasting=4, jumps=[PRIOR**2] * 4, offsets=[PRIOR**2] * 4,
    weight=2, explained=3, recent=3, moved=1, reading=[-1.0], stood=1, usual=1, gained=1, speed=1,
    rough=2, own=2, drifted=2, doubts=2, unexplained=1,
)  # fmt: skip


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
    full = fresh * (time >= WINDOW)
    flown = position - known.begin
    difference = flown - way
    difference[2] *= flown[2] != 0.0  # a height that stays the same is judged by itself
    error, error_before = ca.norm_2(difference), ca.norm_2(known.error)
    changed = full * far * known.odd * (error < ca.norm_2(flown - by_expected))
    limit = CONTRARY * time + NOISE_MULTIPLE * noise
    along = ca.dot(difference, known.error) > ALIKE * error * error_before
    kept = ca.logic_and(known.contrary >= CONTRARY_TIME, error > AGREEING * limit)
    contrary = ca.fmin(ca.if_else(along, known.contrary, 0.0) + WINDOW, CONTRARY_TIME)
    contrary = ca.if_else(error > limit, contrary, 0.0)
    contrary = ca.if_else(kept, known.contrary, contrary)
    climb, most = way[2], ca.fabs(way[2])
    height = ca.fmin(ca.fmax(flown[2], -most), most)
    climbs = math.exp(-1.0 / CLIMBS) * known.climbs + climb * ca.vertcat(height, climb)
    climbs = ca.if_else(full * (most > CLIMBING * time), climbs, known.climbs)
    against = climbs[0] < AGAINST * climbs[1]
    against *= climbs[1] > LEAST_CLIMB + SURE_CLIMB * noise**2
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
    """Whether a position in [m] is measured that is not the last one in ``known``."""
    return present * (ca.sumsqr(position - known.last) > 0.0)


def position_checked(
    known: SimpleNamespace,
    elapsed: ca.SX,
    position: ca.SX,
    present: ca.SX,
    carried: ca.SX,
    climb: ca.SX,
    deviation: ca.SX,
) -> tuple[SimpleNamespace, ca.SX, ca.SX, ca.SX, ca.SX, ca.SX]:
    """What is known after a position, its state by :data:`CODE`, and what of it is used.

    Then on which axes it is the measured one, shape (3,), whether it jumps, and whether positions
    scatter: one after the other is far off, each elsewhere, so that their noise must have grown.

    Args:
        known: By :data:`POSITION_CHECK`: for how long positions have been elsewhere [s], how long
            ago the last one was measured [s], how far it was from where the velocity leads [m],
            what of a jump is still to be told [m], the last position [m], how far the aircraft has
            climbed since the height changed last [m].
        elapsed: Since the measurement before in [s].
        position: As measured, shape (3,), in [m].
        present: 1 where one is measured, else 0.
        carried: Where the ground velocity leads, shape (3,), in [m].
        climb: Upward ground velocity in [m/s].
        deviation: Standard deviation of the noise on the worst axis in [m].
    """
    limit = JUMP + NOISE_MULTIPLE * deviation
    fresh = is_fresh(known, position, present)
    repeated = ca.logic_and(present, ca.logic_not(fresh))
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
    moved = ca.logic_and(far * fresh, jumped >= JUMP_TIME)
    waits = lasts * ca.logic_not(moved) * ca.logic_not(stale)
    silent = ca.logic_not(present) * stale
    stuck = ca.logic_or(far * repeated * stale, level) * ca.logic_not(ca.logic_or(waits, silent))
    code = CODE[JUMPED] * waits + CODE[STUCK] * stuck + CODE[SILENT] * silent
    used = fresh * ca.logic_not(waits)
    after = SimpleNamespace(
        jumped=ca.if_else(moved, 0.0, jumped),
        age=age,
        off=ca.if_else(fresh, off, known.off),
        faded=known.faded * ca.exp(-elapsed / FADE_TIME),
        last=ca.if_else(present, position, known.last),
        climbed=climbed,
    )
    seen_axes = used * ca.vertcat(1.0, 1.0, ca.logic_not(old))
    return after, code, ca.if_else(seen_axes, position, carried), seen_axes, moved, scattered


def air_checked(
    known: SimpleNamespace,
    elapsed: ca.SX,
    heading: ca.SX,
    reading: ca.SX,
    present: ca.SX,
    level: ca.SX,
    air: tuple[ca.SX, ca.SX],
    wind_deviations: ca.SX,
    settled: ca.SX,
    explained: ca.SX,
    turn_told: ca.SX,
    strayed: ca.SX,
    acceleration: ca.SX,
) -> tuple[SimpleNamespace, list[ca.SX], ca.SX, ca.SX]:
    """What is known after airspeed and heading, which of them is left out, and what the wind tells.

    The latter are the heading [rad] and the level airspeed [m/s].

    Args:
        known: By :data:`AIR_CHECK`.
        elapsed: Since the measurement before in [s]; 0 where the flight begins.
        heading: As measured in [rad].
        reading: Airspeed as measured in [m/s].
        present: 1 where there is a reading, else 0.
        level: Share of it that is level, less what it is known to read too much, [-].
        air: u by a wind that owes nothing to the airspeed, and by one that owes nothing to the
            heading, shape (2,) each, in [m/s].
        wind_deviations: Standard deviations of these winds, shape (2,), in [m/s]; a sensor is
            judged while that of its wind is small.
        settled: Whether the flight has lasted so long that no wind will be known better.
        explained: Of the estimate that owes nothing to the airspeed what it holds for wind and
            gust, and for the heading's bias times airspeed, shape (3,), in [m/s].
        turn_told: Whether anything tells how the heading turns.
        strayed: What the compass has turned by otherwise than the gyros measure, in [rad].
        acceleration: v' as commanded and flown in [m/s^2].
    """
    known = SimpleNamespace(**vars(known))
    gained = level * (reading - known.reading - elapsed * acceleration)
    along = air[0][0] * ca.cos(heading) + air[0][1] * ca.sin(heading)
    reason, is_heading = ca.vertsplit(known.reasons)
    was_silent = reason == CODE[SILENT]
    reason = ca.if_else(was_silent, CODE[USED], reason)
    weight = ca.if_else(ca.logic_and(present, was_silent), 0.0, known.weight)
    reason = _stuck(known, elapsed, reason, reading, along, acceleration)
    reasons = ca.vertcat(ca.if_else(present, reason, CODE[SILENT]), is_heading)

    residuals = []
    for each, before in zip(air, (known.now[1], known.now[3]), strict=True):
        speed = ca.norm_2(each)
        off = ca.remainder(ca.atan2(each[1], each[0]) - heading, math.tau)
        # A residual of half a turn must not cancel itself by its sign.
        before = before / ca.fmax(speed, FLYING)
        same = off + math.tau * _turns(before - off)
        off = ca.if_else(ca.fabs(same) < HALF_TURN, same, off)
        # As residuals change with the sensors, where a compass has turned about as well.
        turned = math.tau * _turns(before - same - strayed) + strayed
        own = ca.vertcat(gained, -speed * turned)
        residuals += [ca.if_else(present, level * reading - speed, 0.0), speed * off]
    enough = ca.if_else(settled, WIND_IN_GUSTS, WIND_KNOWN)
    known_winds = ca.logic_and(elapsed > 0.0, wind_deviations <= enough)
    compared = ca.vertsplit(known_winds)
    moved = ca.fmax(
        ca.norm_2(explained - known.explained), known.moved * ca.exp(-elapsed / CHANGES)
    )
    followed, recent = (
        value + ca.fmin(elapsed / time, 1.0) * (explained - value)
        for value, time in ((known.explained, CHANGES), (known.recent, CHANGE_TIME))
    )
    agreed, after = _compared(
        known,
        elapsed,
        reasons,
        weight,
        ca.vertcat(*residuals),
        own,
        turn_told,
        ca.vertcat(*TURNED) * wind_deviations,
        moved,
        ca.norm_2(explained - recent),
    )
    for name, value in vars(after).items():
        judged = {4: _of_residuals(known_winds), 2: known_winds, 1: compared[AIRSPEED]}[
            value.numel()
        ]
        setattr(known, name, ca.if_else(judged, value, getattr(known, name)))
    known.weight = ca.if_else(known_winds, after.weight, 0.0)
    known.moved = ca.if_else(compared[AIRSPEED], moved, 0.0)
    known.explained = ca.if_else(compared[AIRSPEED], followed, explained)
    known.recent = ca.if_else(compared[AIRSPEED], recent, explained)
    known.reasons = ca.if_else(known_winds, agreed, reasons)
    gate = GATE + DEVIATIONS * ca.sqrt(known.jumps[1 + AIRSPEED]) + moved
    # When the comparison begins, the wind may still be what is wrong.
    early = known.weight[AIRSPEED] < PRIOR_TIME + LASTING
    gate += early * DEVIATIONS * wind_deviations[AIRSPEED]
    error = ca.fabs(residuals[AIRSPEED])
    own = ca.sign(residuals[AIRSPEED]) * (known.own[AIRSPEED] + known.rough[AIRSPEED])
    far = (known.weight[AIRSPEED] > 0.0) * (error > gate) * (own > OWN_SHARE * error)
    no_airspeed = ca.logic_or(known.reasons[AIRSPEED] > 0.0, far)
    no_heading = known.reasons[HEADING] > 0.0
    way = ca.if_else(no_airspeed, air[0], air[1])
    along = ca.if_else(no_heading, ca.norm_2(air[0]), along)
    out = [no_airspeed, no_heading]
    return known, out, ca.atan2(way[1], way[0]), ca.fmax(along, 0.0)


def repeated(state: ca.SX, stuck: ca.SX) -> ca.SX:
    """State by :data:`CODE` after a reading; one that is no longer stuck must agree first."""
    freed = ca.logic_and(state == CODE[STUCK], ca.logic_not(stuck))
    state = ca.if_else(ca.logic_and(state == CODE[USED], stuck), CODE[STUCK], state)
    return ca.if_else(freed, CODE[JUMPED], state)


def _stuck(
    known: SimpleNamespace,
    elapsed: ca.SX,
    reason: ca.SX,
    reading: ca.SX,
    along: ca.SX,
    acceleration: ca.SX,
) -> ca.SX:
    """State of an airspeed that may stay the same, compared with how the aircraft is accelerated.

    ``known`` takes what is known after it.
    """
    changed = ca.logic_not(reading == known.reading)
    stood = known.stood + elapsed
    # How long it may stand: as long as it has lately, while it was not stuck.
    longest = ca.fmax(known.usual * ca.exp(-elapsed / COMPARED), (reason != CODE[STUCK]) * stood)
    known.usual = ca.if_else(changed, longest, known.usual)
    known.stood = ca.if_else(changed, 0.0, stood)
    known.gained = ca.if_else(changed, 0.0, known.gained + elapsed * acceleration)
    known.speed = ca.if_else(changed, along, known.speed)
    known.reading = reading
    # Where the autopilot goes by it, too, the speed changes though nothing is commanded.
    unusual = (known.usual > 0.0) * (known.stood > LONGER * known.usual)
    off = ca.fabs(along - known.speed)
    gained = ca.fmin(ca.fabs(known.gained), off) > STUCK_CHANGE
    gained = ca.logic_or(gained, unusual * (off > UNTOLD_CHANGE))
    stands = ca.logic_and(known.stood > STUCK_FOR, gained)
    stays = ca.logic_and(ca.logic_not(changed), reason == CODE[STUCK])
    return repeated(reason, ca.logic_or(stands, stays))


def _compared(
    known: SimpleNamespace,
    elapsed: ca.SX,
    reasons: ca.SX,
    weight: ca.SX,
    residuals: ca.SX,
    own: ca.SX,
    turn_told: ca.SX,
    turned: ca.SX,
    changes: ca.SX,
    lately: ca.SX,
) -> tuple[ca.SX, SimpleNamespace]:
    """States of both sensors, and the rest of what is known, after residuals have been followed."""
    fresh = weight == 0.0
    begins = _of_residuals(fresh)
    now, before = (ca.if_else(begins, residuals, each) for each in (known.now, known.before))
    lasting = ca.if_else(begins, 0.0, known.lasting)
    weight = ca.fmin(ca.if_else(fresh, PRIOR_TIME, weight) + elapsed, COMPARED)
    now += ca.fmin(elapsed / SMOOTHING, 1.0) * (residuals - now)
    before += elapsed / CHANGE_TIME * (now - before)
    lasting += elapsed / LASTING * (now - lasting)
    rough = ca.if_else(fresh, 0.0, known.rough + own)
    smooth = ca.fmin(elapsed / SMOOTHING, 1.0) * rough
    drifted = ca.if_else(fresh, 0.0, (1.0 - elapsed / CHANGES) * known.drifted + smooth)
    high_low = ca.vertcat(1.0, -1.0)
    doubts = ca.fmin(high_low * now[AIRSPEED], high_low * drifted[AIRSPEED]) - DOUBT
    late = weight[AIRSPEED] >= PRIOR_TIME + LASTING  # until then the wind may be what is wrong
    doubts *= late
    # It goes once the residual has gone: what has changed fades, and gusts may hide it for a while.
    fading = ca.fmax(high_low * lasting[AIRSPEED], known.doubts * (1.0 - elapsed / LASTING))
    doubts = ca.fmax(doubts, ca.fmin(known.doubts, fading))
    owned = (1.0 - elapsed / CHANGE_TIME) * (ca.if_else(fresh, 0.0, known.own) + smooth)

    # In turbulence a wind that is not well known goes quickly elsewhere; and a heading is judged by
    # a wind that does not know it.
    jumps, its_jump, its_lasting = now - before, (now - before)[ITS], lasting[ITS]
    usual = DEVIATIONS * ca.sqrt(known.jumps[OTHER] + turned**2)
    usual = ca.fmax(usual, OWN_DEVIATIONS * ca.sqrt(known.jumps[ITS]))
    usual = ca.fmax(usual, ca.vertcat(lately, 0.0))
    most = ca.fmax(LEAST_JUMP + usual, DOMINANCE * ca.fabs(jumps[OTHER]))
    least = LEAST_OFFSET + DEVIATIONS * ca.sqrt(known.offsets[OTHER])
    least = ca.fmax(least, DOMINANCE * ca.fabs(lasting[OTHER])) + ca.vertcat(changes, 0.0)
    by_sensor, size = ca.sign(its_jump) * owned, ca.fabs(its_jump)
    by_sensor[HEADING] = ca.if_else(turn_told, by_sensor[HEADING], size[HEADING])
    by_air = (size > most) * (by_sensor < LEAST_SHARE * size)
    by_air *= ca.fabs(before[ITS]) < size  # not some gust while a sensor is off for long
    jumped = (size > most) * (by_sensor > OWN_SHARE * size)
    # An airspeed's bias from the start is no drift: the filters estimate it, the quicker the more
    # of it is not explained.
    drifts = ca.sign(its_lasting) * drifted > OWN_SHARE * ca.fabs(its_lasting)
    drifts *= (weight >= ca.DM([COMPARED, PRIOR_TIME + LASTING])) * ca.vertcat(1.0, turn_told)
    both_used = ca.mmax(reasons) == CODE[USED]
    beyond = ca.fabs(its_lasting) - least
    off = (beyond > 0.0) * drifts
    unexplained = late * both_used * (beyond[HEADING] <= 0.0) * ca.fmax(beyond[AIRSPEED], 0.0)
    found = ca.if_else(jumped, CODE[JUMPED], off * CODE[OFF])
    agrees = ca.fabs(now[ITS]) < AGREEING * ca.fmin(most, least)
    agrees[AIRSPEED] *= known.stood < STUCK_FOR
    agrees *= ca.logic_or(reasons == CODE[JUMPED], reasons == CODE[OFF])
    agreed = ca.if_else(agrees, known.agreed + elapsed, 0.0)
    again = agreed > AGREED_FOR
    free = both_used * ca.vertcat(1.0, found[AIRSPEED] == CODE[USED])
    reasons = ca.if_else(free, found, reasons)
    by_air *= reasons == CODE[JUMPED]
    reasons = ca.if_else(ca.logic_or(again, by_air), CODE[USED], reasons)
    anew = ca.repmat(again, 2)
    before, lasting = (ca.if_else(anew, now, value) for value in (before, lasting))
    share = elapsed / _of_residuals(weight) * ca.repmat(reasons == CODE[USED], 2)
    after = SimpleNamespace(
        now=now,
        before=before,
        lasting=lasting,
        weight=weight,
        agreed=agreed,
        rough=rough - smooth,
        own=owned,
        drifted=drifted,
        doubts=ca.if_else(again[AIRSPEED], 0.0, doubts),
        unexplained=unexplained,
        jumps=known.jumps + share * ((now - before) ** 2 - known.jumps),
        offsets=known.offsets + share * (lasting**2 - known.offsets),
    )
    return reasons, after


def _turns(angle: ca.SX) -> ca.SX:
    """Whole turns that are nearest to an angle in [rad]."""
    return ca.floor(angle / math.tau + 0.5)


def _of_residuals(winds: ca.SX) -> ca.SX:
    """Of each of the four residuals, from what is of each of the two winds."""
    return winds[[0, 0, 1, 1]]
