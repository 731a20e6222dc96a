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

r"""Which airspeeds and headings are believed.

They are compared with the wind triangle. With the ground velocity :math:`v_g` and the mean wind w,
the velocity through the air is :math:`u = v_g - w`. It is to be as fast as the airspeed, and to
point along the heading:

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

A compass is compared with the gyros, too: their difference, less the gyros' bias, shows one that
drifts. What it jumps by is subtracted; so it is of the direction of the air velocity while gyros
are all that it can be compared with: without an airspeed, and until the wind is known. One that
then drifts far is left out, and the gyros alone tell the heading.

These are expressions: :mod:`~uav_tracking_mpc.estimation.air_estimate` compiles them.
"""

from __future__ import annotations

import math
from types import SimpleNamespace

import casadi as ca

from uav_tracking_mpc.estimation.flight_path import LEAST_AIRSPEED, NOSE_JUMP
from uav_tracking_mpc.estimation.motion_check import (
    DEVIATIONS,
    ODD,
    RETURN,
    STEEPEST,
    SUDDEN,
    WINDOW,
)
from uav_tracking_mpc.estimation.noise_meter import EARLY, MEMORY
from uav_tracking_mpc.estimation.sensor_health import CODE, JUMPED, OFF, SILENT, STUCK, USED
from uav_tracking_mpc.estimation.state_gate import NOISE_MULTIPLE
from uav_tracking_mpc.symbolic.layout import Layout

# Airspeed and heading by the wind

# s: time constants of the noise of a residual, of its jumps, and of what lasts. A sensor must have
# agreed for CHANGE_TIME to be used again.
SMOOTHING, CHANGE_TIME, LASTING = 0.7, 4.0, 7.0
# -, standard deviations of its own residual that gusts explain. Those along a real aircraft show as
# airspeed before they move it, those across it hardly.
OWN_DEVIATIONS = 3.0
LEAST = 1.0  # m/s, that a jump, and what lasts, must exceed in still air
IRON = 0.08  # rad, by which a sound compass errs in the field of its aircraft's own iron
DOMINANCE = 3.0  # -, least ratio of the residual of a sensor that fails to the other one
# rad, that the error of a wind turns against the heading during a jump: of the wind without
# airspeed, and of that without heading. With 0.3 of both a sound heading was blamed in gusts.
TURNED = 0.3, 0.7
# m/s: standard deviation of the wind above which nothing is compared, and by which a sound airspeed
# may read otherwise than it; and late in a flight, when gusts let no wind be known better
WIND_KNOWN, WIND_IN_GUSTS = 1.5, 2.5
CLIPPED = 9.0  # -, mean squares that a jump counts at most among them, or it would hide itself
PRIOR = 0.5  # m/s, gusts that are taken at first, with the weight EARLY
OWN_SHARE = 0.5  # -, share of a jump that is the sensor's own, above which it is named
HALF_TURN = math.pi + 0.5  # rad, greatest difference of headings
# m/s, -: by which the speed changes, by more than the steps of a coarse reading, while one that is
# stuck stays: as commanded, or for so many times as long as usual
STUCK_CHANGE, LONGER = 0.5, 10.0
AIRSPEED, HEADING = 0, 1  # indices of the sensors
ITS, OTHER = [0, 3], [1, 2]  # indices of residuals: of each sensor, and the other one by that wind
# Residuals (r, c) in m/s by the wind without airspeed, then by that without heading: without noise,
# as of some seconds ago, and what lasts; and mean squares of what gusts make of them. Of both
# sensors' own changes in m/s what is taken for noise so far, what is a jump, what lasts. By how
# much in m/s an airspeed may be too high, and too low, that nobody has found wrong yet; which part
# of what lasts nothing else explains; and by how much it has leapt while nothing was compared.
AIR_CHECK = Layout(
    reasons=2, agreed=2, now=4, before=4, lasting=4, jumps=[PRIOR**2] * 4, offsets=[PRIOR**2] * 4,
    weight=2, explained=3, recent=3, moved=1, reading=[-1.0], stood=1, usual=1, gained=1, speed=1,
    rough=2, own=2, drifted=2, doubts=2, unexplained=1, leapt=1,
)  # fmt: skip

# The compass by the gyros

# rad/s: a heading jumps if it differs from that of the gyros by more than NOSE_JUMP, plus SNAP_RATE
# times the time since the last one, plus NOISE_MULTIPLE standard deviations of its noise.
SNAP_RATE = 0.3
# s: memory of the gyros' bias, usually and while nobody else judges the compass: its drift must not
# be taken for a bias before it is found
GYRO_TIME, ALONE_TIME = 120.0, 600.0
DRIFTED = 0.35  # rad, of straying within GYRO_TIME; a compass with 9 deg of iron strays by less
COMPASS_CHECK = Layout(nose=1, snapped=1, rate=1, known_for=1, astray=1, drifted=1)


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
    likelier: ca.SX,
    turn_told: ca.SX,
    strayed: ca.SX,
    astray: ca.SX,
    acceleration: ca.SX,
    stuck: ca.SX,
    noise: ca.SX,
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
        likelier: Whether the wind that owes nothing to the heading is weaker than the one with it.
        turn_told: Whether anything tells how the heading turns.
        strayed: What the compass has turned by otherwise than the gyros measure, in [rad].
        astray: How much of that it has lately, in [rad].
        acceleration: v' as commanded and flown in [m/s^2].
        stuck: Whether the heading is stuck.
        noise: Standard deviation of the airspeed's noise in [m/s].
    """
    known = SimpleNamespace(**vars(known))
    gained = level * (reading - known.reading - elapsed * acceleration)
    along = air[0][0] * ca.cos(heading) + air[0][1] * ca.sin(heading)
    reason, is_heading = ca.vertsplit(known.reasons)
    was_silent = reason == CODE[SILENT]
    weight = ca.if_else(ca.logic_and(present, was_silent), 0.0, known.weight)
    # The airspeed itself tells at once, compared or not: no gust changes it as quickly.
    leap = gained - level * known.gained
    leaps = present * (known.reading >= 0.0) * ca.logic_not(was_silent)
    leaps *= ca.fabs(leap) > SUDDEN + STEEPEST * elapsed + DEVIATIONS * noise
    known.leapt = (known.reasons[AIRSPEED] > 0.0) * known.leapt + leaps * leap
    judged = ca.logic_not(present) * (reason > CODE[SILENT])  # which a silence does not clear
    known.leapt = ca.if_else(judged, SUDDEN, known.leapt)
    leapt = (ca.fabs(known.leapt) > RETURN * SUDDEN) * CODE[JUMPED]
    leaps *= ca.logic_or(reason == CODE[USED], reason == CODE[JUMPED])
    reason = ca.if_else(ca.logic_or(was_silent, leaps), leapt, reason)
    reason = _stuck(known, elapsed, reason, reading, along, acceleration)
    is_heading = repeated(ca.if_else(stuck, CODE[USED], is_heading), stuck)  # whatever else it was
    known.reasons = ca.vertcat(ca.if_else(present, reason, CODE[SILENT]), is_heading)

    residuals = []
    for each, before in zip(air, (known.now[1], known.now[3]), strict=True):
        speed = ca.norm_2(each)
        off = ca.remainder(ca.atan2(each[1], each[0]) - heading, math.tau)
        # A residual of half a turn must not cancel itself by its sign.
        before = before / ca.fmax(speed, LEAST_AIRSPEED)
        same = off + math.tau * _turns(before - off)
        off = ca.if_else(ca.fabs(same) < HALF_TURN, same, off)
        # As residuals change with the sensors, where a compass has turned about as well.
        turned = math.tau * _turns(before - same - strayed) + strayed
        own = ca.vertcat(gained, -speed * turned)
        residuals += [ca.if_else(present, level * reading - speed, 0.0), speed * off]
    enough = ca.if_else(settled, WIND_IN_GUSTS, WIND_KNOWN)
    known_winds = ca.logic_and(elapsed > 0.0, wind_deviations <= enough)
    after = _compared(
        known,
        elapsed,
        weight,
        ca.vertcat(*residuals),
        own,
        turn_told,
        ca.vertcat(*TURNED) * wind_deviations,
        explained,
        likelier * (ca.fabs(astray) > 2.0 * IRON),
        ca.vertcat(0.0, IRON * ca.norm_2(air[1])),
    )
    # What is known where nothing is compared
    known.weight, known.moved, known.explained, known.recent = 0.0, 0.0, explained, explained
    airspeed_compared = known_winds[AIRSPEED]
    for name, value in vars(after).items():
        judged = {4: _of_residuals(known_winds), 2: known_winds}.get(
            value.numel(), airspeed_compared
        )
        setattr(known, name, ca.if_else(judged, value, getattr(known, name)))
    no_airspeed, no_heading = (known.reasons[k] > 0.0 for k in (AIRSPEED, HEADING))
    way = ca.if_else(no_airspeed, air[0], air[1])
    along = ca.if_else(no_heading, ca.norm_2(air[0]), along)
    return known, [no_airspeed, no_heading], ca.atan2(way[1], way[0]), ca.fmax(along, 0.0)


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
    longest = ca.fmax(known.usual * ca.exp(-elapsed / MEMORY), (reason != CODE[STUCK]) * stood)
    known.usual = ca.if_else(changed, longest, known.usual)
    known.stood = ca.if_else(changed, 0.0, stood)
    known.gained = ca.if_else(changed, 0.0, known.gained + elapsed * acceleration)
    known.speed = ca.if_else(changed, along, known.speed)
    known.reading = reading
    # Where the autopilot goes by it, too, the speed changes though nothing is commanded.
    unusual = (known.usual > 0.0) * (known.stood > LONGER * known.usual)
    off = ca.fabs(along - known.speed)
    explained = ca.logic_or(ca.fabs(known.gained) > STUCK_CHANGE, unusual)
    stands = (known.stood > WINDOW) * explained * (off > STUCK_CHANGE)
    stays = ca.logic_and(ca.logic_not(changed), reason == CODE[STUCK])
    return repeated(reason, ca.logic_or(stands, stays))


def _compared(
    known: SimpleNamespace,
    elapsed: ca.SX,
    weight: ca.SX,
    residuals: ca.SX,
    own: ca.SX,
    turn_told: ca.SX,
    turned: ca.SX,
    explained: ca.SX,
    likelier: ca.SX,
    iron: ca.SX,
) -> SimpleNamespace:
    """What is known after residuals have been followed, with the states of both sensors."""
    # By what the wind without airspeed has changed lately, it may also have changed along the
    # heading, where it is not seen.
    moved = ca.norm_2(explained - known.explained)
    moved = ca.fmax(moved, known.moved * ca.exp(-elapsed / MEMORY))
    followed = known.explained + ca.fmin(elapsed / MEMORY, 1.0) * (explained - known.explained)
    recent = known.recent + ca.fmin(elapsed / CHANGE_TIME, 1.0) * (explained - known.recent)
    fresh, reasons = weight == 0.0, known.reasons
    begins = _of_residuals(fresh)
    now, before = (ca.if_else(begins, residuals, each) for each in (known.now, known.before))
    lasting = ca.if_else(begins, 0.0, known.lasting)
    weight = ca.fmin(ca.if_else(fresh, EARLY, weight) + elapsed, MEMORY)
    now += ca.fmin(elapsed / SMOOTHING, 1.0) * (residuals - now)
    before += elapsed / CHANGE_TIME * (now - before)
    lasting += elapsed / LASTING * (now - lasting)
    rough = ca.if_else(fresh, 0.0, known.rough + own)
    smooth = ca.fmin(elapsed / SMOOTHING, 1.0) * rough
    drifted = ca.if_else(fresh, 0.0, (1.0 - elapsed / MEMORY) * known.drifted + smooth)
    high_low = ca.vertcat(1.0, -1.0)
    late = weight[AIRSPEED] >= EARLY + LASTING  # until then the wind may be what is wrong
    doubts = late * (ca.fmin(high_low * now[AIRSPEED], high_low * drifted[AIRSPEED]) - WIND_KNOWN)
    # It goes once the residual has gone: what has changed fades, and gusts may hide it for a while.
    fading = ca.fmax(high_low * lasting[AIRSPEED], known.doubts * (1.0 - elapsed / LASTING))
    doubts = ca.fmax(doubts, ca.fmin(known.doubts, fading))
    owned = (1.0 - elapsed / CHANGE_TIME) * (ca.if_else(fresh, 0.0, known.own) + smooth)

    # In turbulence a wind that is not well known goes quickly elsewhere; and a heading is judged by
    # a wind that does not know it.
    jumps, its_jump, its_lasting = now - before, (now - before)[ITS], lasting[ITS]
    usual = DEVIATIONS * ca.sqrt(known.jumps[OTHER] + turned**2)
    usual = ca.fmax(usual, OWN_DEVIATIONS * ca.sqrt(known.jumps[ITS]))
    usual = ca.fmax(usual, ca.vertcat(ca.norm_2(explained - recent), 0.0))
    most = ca.fmax(LEAST + usual, DOMINANCE * ca.fabs(jumps[OTHER]))
    least = LEAST + iron + DEVIATIONS * ca.sqrt(known.offsets[OTHER])
    least = ca.fmax(least, DOMINANCE * ca.fabs(lasting[OTHER])) + ca.vertcat(moved, 0.0)
    by_sensor, size = ca.sign(its_jump) * owned, ca.fabs(its_jump)
    by_sensor[HEADING] = ca.if_else(turn_told, by_sensor[HEADING], size[HEADING])
    jumped = (size > most) * (by_sensor > OWN_SHARE * size)
    by_air = (size > most) * (by_sensor < RETURN * OWN_SHARE * size)
    # An autopilot that goes by a wrong airspeed accelerates the aircraft: no air has changed while
    # the airspeed has not come back.
    gone = ca.sign(its_jump[AIRSPEED]) * drifted[AIRSPEED]
    by_air[AIRSPEED] *= gone < RETURN**2 * OWN_SHARE * size[AIRSPEED]
    # An airspeed's bias from the start is no drift: the filters estimate it, the quicker the more
    # of it is not explained. A heading that was astray before anything was compared has not drifted
    # since, but no gust that would explain it lasts, and the gyros know of it.
    both_used = ca.mmax(reasons) == CODE[USED]
    beyond = ca.fabs(its_lasting) - least
    drifts = ca.sign(its_lasting) * drifted > OWN_SHARE * ca.fabs(its_lasting)
    drifts[HEADING] = ca.logic_or(drifts[HEADING], likelier * (beyond[HEADING] > ODD))
    drifts *= (weight >= ca.DM([MEMORY, EARLY + LASTING])) * ca.vertcat(1.0, turn_told)
    off = (beyond > 0.0) * drifts
    unexplained = late * both_used * (beyond[HEADING] <= 0.0) * ca.fmax(beyond[AIRSPEED], 0.0)
    found = ca.if_else(jumped, CODE[JUMPED], off * CODE[OFF])
    agrees = ca.fabs(now[ITS]) < RETURN * ca.fmin(most, least)
    agrees[AIRSPEED] *= known.stood < WINDOW
    agrees *= ca.logic_or(reasons == CODE[JUMPED], reasons == CODE[OFF])
    agreed = ca.if_else(agrees, known.agreed + elapsed, 0.0)
    again = agreed > CHANGE_TIME
    free = both_used * ca.vertcat(1.0, found[AIRSPEED] == CODE[USED])
    reasons = ca.if_else(free, found, reasons)
    # Not some gust while a sensor is off for long.
    by_air *= (ca.fabs(before[ITS]) < size) * (reasons == CODE[JUMPED])
    reasons = ca.if_else(ca.logic_or(again, by_air), CODE[USED], reasons)
    before, lasting = (ca.if_else(ca.repmat(again, 2), now, each) for each in (before, lasting))
    share = elapsed / _of_residuals(weight) * ca.repmat(reasons == CODE[USED], 2)
    return SimpleNamespace(
        reasons=reasons,
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
        moved=moved,
        explained=followed,
        recent=recent,
        jumps=known.jumps + share * (ca.fmin(jumps**2, CLIPPED * known.jumps) - known.jumps),
        offsets=known.offsets + share * (lasting**2 - known.offsets),
    )


def _turns(angle: ca.SX) -> ca.SX:
    """Whole turns that are nearest to an angle in [rad]."""
    return ca.floor(angle / math.tau + 0.5)


def _of_residuals(winds: ca.SX) -> ca.SX:
    """Of each of the four residuals, from what is of each of the two winds."""
    return winds[[0, 0, 1, 1]]


def compass_checked(
    known: SimpleNamespace,
    elapsed: ca.SX,
    nose: ca.SX,
    turn: ca.SX,
    alone: ca.SX,
    by_nose: ca.SX,
    stuck: ca.SX,
    deviation: ca.SX,
) -> tuple[SimpleNamespace, ca.SX, ca.SX]:
    """What is known after a compass, what it strays by from the gyros, and by what it has jumped.

    The latter two in [rad]: since the compass before, less a jump that is subtracted; and since it
    has been right.

    Args:
        known: By :data:`COMPASS_CHECK`: the compass before, by how much it has jumped [rad], how
            quickly it strays from the gyros on average [rad/s], since when that is known [s], by
            how much it has strayed lately [rad], and whether that was too much.
        elapsed: Since the compass before in [s].
        nose: Where the compass says that the nose points, in [rad].
        turn: How it turns by the gyros, as they are measured, in [rad/s].
        alone: Whether the gyros tell the turn, and nothing else what to make of the heading.
        by_nose: Whether they tell how the nose turns, so that no air that changes turns the
            compass beside them.
        stuck: Whether the compass stays the same though the aircraft turns.
        deviation: Standard deviation of the heading's noise in [rad].
    """
    turned = ca.remainder(nose - known.nose, math.tau)
    apart = (elapsed > 0.0) * ca.remainder(turned - elapsed * turn, math.tau)
    unusual, most = apart - elapsed * known.rate, SNAP_RATE * elapsed
    jumps = ca.logic_or(ca.fabs(unusual) > NOSE_JUMP + most + NOISE_MULTIPLE * deviation, stuck)
    known_for = ca.fmin(known.known_for + elapsed, ca.if_else(alone, ALONE_TIME, GYRO_TIME))
    # A jump is no bias. What is averaged is kept in bounds, and not what it differs by: else a
    # first noisy compass would stay in the average for minutes.
    learnt = ca.fmax(-most, ca.fmin(apart, most)) - elapsed * known.rate
    change = ca.logic_not(jumps) * ca.if_else(known_for > 0.0, learnt / known_for, 0.0)
    strayed = unusual - elapsed * change
    # It is the compass that leaps if it has turned by more than the gyros say. What is subtracted
    # is so until it has leapt back, whoever may judge by then.
    leaps = by_nose * jumps * (ca.fabs(turned) > elapsed * ca.fabs(turn))
    alone = ca.logic_or(ca.logic_or(alone, leaps), ca.fabs(known.snapped) > RETURN * NOSE_JUMP)
    jump = alone * jumps * strayed
    # Gyros that drift so quickly are rarer: once it has drifted, they alone tell the heading.
    drifted, lately = known.drifted, ca.exp(-elapsed / GYRO_TIME)
    often = most < NOSE_JUMP  # what is seldom measured may have turned otherwise in between
    astray = ca.logic_not(drifted) * (lately * known.astray + often * (strayed - jump))
    begins = alone * (known_for >= GYRO_TIME) * (ca.fabs(astray) > DRIFTED)
    jump += alone * ca.if_else(drifted, ca.logic_not(jumps) * unusual, begins * astray)
    change -= begins * astray / ca.fmax(known_for, GYRO_TIME)  # what of the drift is in the bias
    snapped = alone * ca.remainder(known.snapped + jump, math.tau)
    after = SimpleNamespace(
        nose=nose,
        snapped=snapped,
        rate=known.rate + ca.logic_not(drifted) * change,
        known_for=known_for,
        astray=astray,
        drifted=alone * ca.logic_or(drifted, begins),
    )
    return after, strayed - jump, snapped
