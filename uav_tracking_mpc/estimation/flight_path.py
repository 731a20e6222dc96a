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

r"""Path through the air of an aircraft whose attitude is measured: what the body does, and is not.

The controller plans the path: where the velocity through the air points, and how it turns. Sensors
aboard tell where the nose points. This is the one place that makes the one of the other, for every
source of measurements.

With bank :math:`\phi`, pitch :math:`\theta` and path angle :math:`\chi` an aircraft that does not
slip flies past its nose by an angle that they tell (:func:`past_nose`). In a roll it slips (adverse
yaw, rudder, Dutch roll): its nose swings to the side, while it turns as its bank says. A controller
that took the swing for a turn would answer it, against the phase, with a limit cycle. Quick changes
are therefore those of the bank, slow ones those of the nose, by a complementary filter (e.g.
Mahony, Hamel, Pflimlin, IEEE Trans. Automatic Control 53(5), 2008):

.. math::

    \dot\psi = r_b + k r_s + b + 2 \omega \beta, \quad \dot r_s = \omega_s (r_b - r_s), \quad
    \beta = \psi_n - \psi, \\
    \dot k = \omega^2 \beta \, r_s / (r_s^2 + \rho^2), \quad
    \dot b = \omega^2 \beta \, \rho^2 / (r_s^2 + \rho^2)

with the direction :math:`\psi_n` that the nose tells and the rate :math:`r_b = -g \tan\phi / v` of
a coordinated turn. An aircraft that slips in a steady turn turns at another rate than that of its
bank: by a share k of it, since the slip grows with the turn (yaw damping), and by b, since none is
symmetric. Both show slowly, and are taken out as slowly. The slip follows a bank with the delay of
the yaw, hence :math:`r_s`: in a quick roll the bank counts in full. Steep turns tell k and flat
ones b; together they learn as quickly at any bank, for :math:`r_s \dot k + \dot b =
\omega^2 \beta`.

Up and down there is no such second source: in turbulence the nose's pitch rate is mostly that of
the gusts and of the answer to them. The measured climb :math:`w_m` is followed instead, by a filter
of second order, which a steady change passes without an error:

.. math::

    \dot w = a + 2 \omega_w (w_m - w), \quad \dot a = \omega_w^2 (w_m - w)

While the measured climb is known to be wrong, it is that of the pitch, which the path follows with
a lag (in operator notation, with time constant tau), and of a part c, which angle of attack and
rising air make; the height h tells it:

.. math::

    w_m = \frac{v \sin\theta}{1 + \tau s} + c, \quad \dot h = w_m + 2 \omega_h (h_m - h), \quad
    \dot c = \omega_h^2 (h_m - h)

This climb tells as well that the measured one is wrong, sooner than the height alone: an aircraft
that is steered by a climb of the other sign is away in two seconds.
"""

from __future__ import annotations

import dataclasses
import math

from uav_tracking_mpc.dynamics.frames import turn_rate_from_bank
from uav_tracking_mpc.estimation.measurement import Axis, Measurement
from uav_tracking_mpc.estimation.motion_check import LEAST_CLIMB, WINDOW
from uav_tracking_mpc.estimation.noise_meter import LONGEST_GAP
from uav_tracking_mpc.estimation.state_gate import NOISE_MULTIPLE

FREQUENCY = 0.3  # rad/s, omega: well below the swing's, which is some rad/s
SURPLUS_LIMIT = 0.15  # rad/s, of a turn's surplus over its bank
SHARE_LIMIT = 0.4  # -, of the surplus that grows with the turn
STEEP_TURN = 0.1  # rad/s, rho: from there on a turn tells more of the share than of the rest
SLIP_FREQUENCY = 1.0  # rad/s, omega_s: how quickly a slip follows the turn
LEAST_AIRSPEED = 3.0  # m/s; below it nothing flies, and the path angle means nothing
NOSE_JUMP = 0.1  # rad, from one attitude to the next, beyond the turn: the compass has jumped
TRIAL = 20.0  # s, over which the turns by bank and by nose are compared
SLOW_TURN = 0.03  # rad/s, up to which a turn tells little of the airspeed
ROLLING = 3.0  # s, over which both are averaged before: the nose does not follow a quick roll
CONTRADICTION = 0.01  # rad^2/s^2, beyond which the bank is left out; a slip makes a quarter of it
STEEPEST = 1.5  # rad, bank or pitch beyond which no turn is coordinated
QUICK_CLIMB = 8.0  # rad/s, where the climb is commanded: it delays by little
STEADY_CLIMB = 2.0  # rad/s, omega_h
HEIGHT_JUMP = 4.0  # m, besides noise, from where the climb leads: the height has jumped
CLIMB_LAG = 0.3  # s, tau, with which a climb follows the nose
# m/s, m, m: a measured climb is wrong if it differs by more than WRONG_CLIMB from that of pitch and
# height (severe gusts make 4 m/s), or within RIGHT_TIME by WRONG_WAY, and the height by more than
# WRONG_HEIGHT from where it leads, within WINDOW
WRONG_CLIMB, WRONG_WAY, WRONG_HEIGHT = 6.0, 10.0, 1.0
# s, -: it is right again once the heights of RIGHT_TIME show this share of it, and the sum of the
# squares of what was climbed exceeds LEAST_CLIMB
RIGHT_TIME, RIGHT_SHARE = 10.0, 0.7
CLIMB_NOISE = 2.0  # m/s, standard deviation of that climb
SLOW_CLIMB = 0.5  # rad/s, where an autopilot holds the altitude, and the rest is turbulence


class FlightDirection:
    """Follows the direction in which one aircraft flies.

    Attributes:
        heading: psi, counter-clockwise from East, in [rad]; not wrapped.
        rate: psi' in [rad/s].
        surplus: k r_s + b, what the turn rate exceeds that of a coordinated turn by, in [rad/s].
        share: k [-].
    """

    def __init__(self) -> None:
        self.heading = self.rate = self.surplus = self.share = 0.0
        self._bank_rate = self._steady = self._rest = 0.0  # r_b, r_s, b

    def see(self, step: float, nose: float | None, bank_rate: float) -> None:
        """Take in an attitude.

        Args:
            step: Since the one before in [s].
            nose: Direction that the nose tells, counter-clockwise from East, in [rad]; None where
                it tells none: the bank alone then counts.
            bank_rate: r_b in [rad/s].
        """
        before, self._bank_rate = self._bank_rate, bank_rate
        if 0.0 < step <= LONGEST_GAP:
            self.heading += step * (0.5 * (before + bank_rate) + self.surplus)
            swing = 0.0 if nose is None else math.remainder(nose - self.heading, 2.0 * math.pi)
            self.heading += 2.0 * FREQUENCY * step * swing
            self._steady += (1.0 - math.exp(-SLIP_FREQUENCY * step)) * (bank_rate - self._steady)
            learnt = FREQUENCY**2 * step * swing / (self._steady**2 + STEEP_TURN**2)
            self.share = _within(self.share + learnt * self._steady, SHARE_LIMIT)
            self._rest = _within(self._rest + learnt * STEEP_TURN**2, SURPLUS_LIMIT)
            self.surplus = _within(self.share * self._steady + self._rest, SURPLUS_LIMIT)
        elif step != 0.0 and nose is not None:
            self.heading = nose
        self.rate = bank_rate + self.surplus


def _within(value: float, limit: float) -> float:
    return min(max(value, -limit), limit)


class Followed:
    """A value that is followed by a filter of second order: of a steady change it has no error.

    Attributes:
        value: In any unit.
        rate: Of it, per s.
    """

    def __init__(self) -> None:
        self.value = self.rate = 0.0

    def see(self, step: float, measured: float, frequency: float) -> None:
        """Take in a measurement, for which the filter's equation is solved as if it stood still.

        After a gap it begins anew.

        Args:
            step: Since the one before in [s].
            measured: The value.
            frequency: omega in [rad/s].
        """
        if not 0.0 <= step <= LONGEST_GAP:
            self.value, self.rate, step = measured, 0.0, 0.0
        faded, error = math.exp(-frequency * step), self.value - measured
        slope = self.rate - frequency * error
        error += step * slope
        self.value = measured + faded * error
        self.rate = faded * (slope + frequency * error)


class Climb:
    """Follows the climb of one aircraft by pitch and height, and judges the measured one by that.

    Attributes:
        missed: What pitch and height tell besides the measured climb, in [m/s].
        failed: Whether the measured climb is wrong.
        nose_climb: v sin theta, followed with the lag, in [m/s].
    """

    def __init__(self) -> None:
        self._besides = Followed()  # h [m] less what the pitch makes of it, and c [m/s]
        self.nose_climb = self._by_pitch = 0.0  # m/s, and m of it
        self._height = math.nan  # m, before
        # m, flown lately by height, measured climb and pitch; m^2 s, of the first two
        self._risen = self._told = self._pitched = self._along = self._squares = 0.0
        self._astray = 0.0  # m, by which what pitch and height tell has led elsewhere
        self.missed, self.failed = 0.0, False

    def see(self, step: float, by_pitch: float, up: float, height: float, noise: float) -> float:
        """Climb by pitch and height in [m/s].

        Args:
            step: Since the measurement before in [s].
            by_pitch: v sin theta in [m/s].
            up: As it is measured in [m/s].
            height: As it is measured in [m]; no number where it is not.
            noise: Standard deviation of the height, as far as it is known, in [m].
        """
        besides, moved = self._besides, min(step, LONGEST_GAP)
        carried = besides.value + moved * besides.rate
        self.nose_climb += (1.0 - math.exp(-moved / CLIMB_LAG)) * (by_pitch - self.nose_climb)
        self._by_pitch += moved * self.nose_climb
        # What repeats itself tells nothing: a height that is stuck would hold the climb at 0.
        rise = 0.0 if math.isnan(height) else height - self._height
        tells, begins = rise != 0.0, math.isnan(rise) or step > LONGEST_GAP
        if begins:
            self.nose_climb, besides.rate = by_pitch, up - by_pitch
            besides.value = height - self._by_pitch if tells else carried
        elif tells:
            elsewhere = height - self._by_pitch
            if abs(elsewhere - carried) <= HEIGHT_JUMP + NOISE_MULTIPLE * noise:
                besides.see(moved, elsewhere, STEADY_CLIMB)
            else:  # one that jumps has not climbed
                besides.value, rise = elsewhere, 0.0
        else:
            besides.value = carried
        self._height = height if tells else self._height
        climb = self.nose_climb + besides.rate
        self.missed = climb - up
        self._judge(moved, 0.0 if begins else rise, up, climb, noise)
        return climb

    def _judge(self, step: float, rise: float, up: float, climb: float, noise: float) -> None:
        """Whether the measured climb is wrong, or right again, by where the height has gone.

        A rise of 0 is that of a height that repeats itself, and tells nothing.
        """
        lately, kept = math.exp(-step / WINDOW), math.exp(-step / RIGHT_TIME)
        self._risen = lately * self._risen + rise
        self._told = lately * self._told + step * up
        self._pitched = lately * self._pitched + step * climb
        self._along = kept * self._along + step * self._risen * self._told
        self._squares = kept * self._squares + step * self._told**2
        self._astray = kept * self._astray + step * self.missed
        off, least = abs(self._risen - self._told), WRONG_HEIGHT + 2.0 * noise
        by_height = rise != 0.0 and off > max(least, abs(self._risen - self._pitched))
        differs = abs(self.missed) > WRONG_CLIMB or abs(self._astray) > WRONG_WAY
        if differs and by_height and not self.failed:
            self.failed, self._along, self._squares = True, 0.0, 0.0
        elif self._squares > LEAST_CLIMB and self._along > RIGHT_SHARE * self._squares:
            self.failed = False


class FlightPath:
    """Makes measurements of the body ones of the path through the air.

    A bank of another sign, or of an aircraft that skids, explains the turn worse than none would:
    r_b (r_b - 2 r_n), averaged, is positive. It is then left out. In turbulence an aircraft rolls
    to and fro quicker than its nose follows; both rates are therefore smoothed before.

    Attributes:
        direction: In which it flies.
        climb: By pitch and height, and what that says of the measured one.
    """

    def __init__(self) -> None:
        self.direction = FlightDirection()
        self._followed = Followed()  # w [m/s] and a [m/s^2]
        self.climb = Climb()
        self._nose = 0.0  # rad
        self._up, self._nose_climb = math.nan, 0.0  # m/s: the climb, and that of the nose with it
        self._time = -math.inf
        self._by_bank = self._by_nose = 0.0  # rad/s, smoothed
        self._banked = self._along = 0.0  # rad^2/s^2, averages of r_b^2 and r_b r_n

    @property
    def contradicted(self) -> bool:
        """Whether the nose turns against the bank."""
        return self._banked - 2.0 * self._along > CONTRADICTION

    @property
    def airspeed_share(self) -> float:
        """Airspeed at which the turn fits the bank, as a share of the one that was gone by [-].

        By averages: gusts from the side swing the nose, and k with it, while the aircraft rolls.
        """
        share = (self._along - self._banked) / (self._banked + SLOW_TURN**2)
        share = _within(share, SHARE_LIMIT)
        return 1.0 if self.contradicted else 1.0 / (1.0 + share)

    def of(
        self,
        measurement: Measurement,
        airspeed: float,
        climb_frequency: float = QUICK_CLIMB,
        height_noise: float = 0.0,
        velocity_failed: bool = False,
        climb_stuck: bool = False,
        heading_failed: bool = False,
        heading_stuck: bool = False,
    ) -> Measurement:
        """The same with climb, heading, path angle and their rates of the air velocity.

        Without a bank the nose is all that is known of it, and is taken for it.

        Args:
            measurement: Not older than the one before.
            airspeed: That belongs to it in [m/s].
            climb_frequency: Up to which changes of the climb count, in [rad/s].
            height_noise: Standard deviation of the height in [m].
            velocity_failed: Whether the ground velocity is known to be wrong, and with it the
                climb.
            climb_stuck: Whether the measured climb is stuck: pitch and height then replace it.
            heading_failed: Whether the heading is wrong: while it turns the other way, the turn
                goes by the bank alone.
            heading_stuck: Whether it is stuck: the turn goes by the bank alone.
        """
        bank, pitch = measurement.bank, measurement.path_angle
        if (
            measurement.axis is Axis.AIR_VELOCITY
            or bank is None
            or airspeed < LEAST_AIRSPEED
            or max(abs(bank), abs(pitch)) > STEEPEST
        ):
            return measurement
        direction, climb = self.direction, self._followed
        step, self._time = measurement.stamp - self._time, measurement.stamp
        ground_velocity = measurement.ground_velocity.copy()
        up, height = float(ground_velocity[2]), float(measurement.position[2])
        noise = measurement.noise
        by_pitch = self.climb.see(step, airspeed * math.sin(pitch), up, height, height_noise)
        if up != self._up:
            self._up, self._nose_climb = up, self.climb.nose_climb
        bridged = up + self.climb.nose_climb - self._nose_climb  # since it was measured
        climb_failed = climb_stuck or self.climb.failed
        up = by_pitch if velocity_failed or climb_failed else bridged
        climb.see(step, up, climb_frequency)
        if not velocity_failed:  # else it shall not agree because it was replaced
            ground_velocity[2] = climb.value
            if climb_failed:
                noise = dataclasses.replace(noise, velocity=(*noise.velocity[:2], CLIMB_NOISE))
        path_angle = math.asin(min(max(climb.value / airspeed, -1.0), 1.0))
        nose = measurement.heading + past_nose(bank, pitch, path_angle)
        by_bank = turn_rate_from_bank(bank, airspeed)
        turned = math.remainder(nose - self._nose, 2.0 * math.pi)
        if 0.0 < step <= LONGEST_GAP and not heading_stuck:
            if abs(turned - step * by_bank) > NOSE_JUMP:
                direction.heading += turned  # for others to judge; it tells nothing of the turn
            else:
                share = step / ROLLING
                self._by_bank += share * (by_bank - self._by_bank)
                self._by_nose += share * (turned / step - self._by_nose)
                lately = 0.0 if heading_failed else step / TRIAL
                along = self._by_bank * self._by_nose
                self._banked += lately * (self._by_bank**2 - self._banked)
                self._along += lately * (along - self._along)
        # A heading that is wrong tells of the turn all the same, unless it turns the other way.
        against = self._by_bank * (self._by_bank - 2.0 * self._by_nose) > 0.0
        no_turn = heading_stuck or (heading_failed and against)
        direction.see(step, None if no_turn else nose, by_bank)
        if no_turn and not heading_stuck:
            direction.heading = nose  # for others to judge whether it is right again
        self._nose = direction.heading if heading_stuck else nose
        if self.contradicted:
            return measurement
        return dataclasses.replace(
            measurement,
            ground_velocity=ground_velocity,
            heading=direction.heading,
            path_angle=path_angle,
            turn_rate=direction.rate,
            path_angle_rate=climb.rate / airspeed,
            noise=noise,
            axis=Axis.AIR_VELOCITY,
        )


def past_nose(bank: float, pitch: float, path_angle: float) -> float:
    """By how much an air velocity without sideslip points to the left of the nose, in [rad].

    Args:
        bank: Right wing down, in [rad].
        pitch: Nose up, in [rad].
        path_angle: chi in [rad].
    """
    sin_pitch, cos_pitch = math.sin(pitch), math.cos(pitch)
    sin_bank, cos_bank = math.sin(bank), math.cos(bank)
    upright = math.hypot(sin_pitch, cos_pitch * cos_bank)
    climb = min(max(math.sin(path_angle) / upright, -1.0), 1.0)
    alpha = math.atan2(sin_pitch, cos_pitch * cos_bank) - math.asin(climb)
    ahead = cos_pitch * math.cos(alpha) + sin_pitch * cos_bank * math.sin(alpha)
    return math.atan2(sin_bank * math.sin(alpha), ahead)
