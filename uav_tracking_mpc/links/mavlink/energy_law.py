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

r"""Pitch and thrust, from path-angle rate and acceleration, for autopilots that are told these.

The inputs lead a reference with the first-order lag that the controller's model gives an aircraft,

.. math::

    \tau_\chi \dot\omega = u_\chi - \omega,\quad \dot\chi_r = \omega, \qquad
    \tau_v \dot a = u_v - a,\quad \dot v_r = a,

and the aircraft follows it. Its pitch comes about with the time constant :math:`T_\theta`, its path
after that with :math:`T_\alpha`, whose inverse leads the command; an integral learns the angle of
attack and a feed-forward of lift has its change with load factor n and airspeed:

.. math::

    \theta = \chi_r + (T_\theta + T_\alpha)\,\omega + T_\theta T_\alpha\,\dot\omega
      + K (\chi_r - \chi) + I_\theta + A\,(n V_c^2 / v^2 - 1)\cos\phi .

The thrust balances the rate of the specific energy, as PX4's TECS does
(src/lib/tecs/TECS.cpp, ``TECSControl::_calcThrottleControlOutput``):

.. math::

    \dot E = v \left(a + g \sin\chi_r + \frac{v_r - v}{T_v} + I_v\right) + R (n - 1), \qquad
    \delta = \delta_t + \begin{cases}
      (\delta_+ - \delta_t)\, \dot E / (g w_+) & \dot E \ge 0 \\
      (\delta_t - \delta_-)\, \dot E / (g w_0) & \dot E < 0
    \end{cases}

Path and airspeed share one energy: outside the limits of the airspeed the path gives way.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from uav_tracking_mpc.dynamics.air import GRAVITY
from uav_tracking_mpc.dynamics.vehicle import followed

PATH_LAG, SPEED_LAG = 0.2, 0.2  # s, tau_chi and tau_v of the reference
LIFT_TIME = 0.25  # s, T_alpha: v / g times the angle of attack per load factor
PATH_GAIN, PATH_INTEGRAL = 0.25, 0.3  # -, 1/s: K, and of I_theta
SPEED_TIME, SPEED_INTEGRAL = 2.0, 0.1  # s, 1/s^2: T_v, and of I_v
LIFT_ANGLE = 0.08  # rad, A: angle of attack at cruise above that of no lift
STALL = 0.25  # rad, the most that angles of attack are learnt to
PATH_WINDOW, SPEED_WINDOW = 0.15, 3.0  # rad, m/s, that the reference may be from what is measured
GIVING_WAY = 0.3  # rad, by which the path gives way to the airspeed at most
SLOW = 2.0  # m/s below the least airspeed, where thrust is full in any case
LONGEST_STEP = 0.2  # s; after a longer pause the reference begins anew
LOAD_LIMIT = 2.0  # -, of the load factor in feed-forwards


class EnergyLimits(NamedTuple):
    """What the law knows of an aircraft, and what its commands keep to.

    Attributes:
        cruise: V_c, equivalent, in [m/s].
        airspeed_min: In level flight, equivalent, in [m/s].
        airspeed_max: Equivalent, in [m/s].
        thrust_min: From 0 to 1 [-].
        thrust_max: From 0 to 1 [-].
        trim: Thrust that holds V_c in level flight at sea level, from 0 to 1 [-].
        trim_slow: Likewise airspeed_min; 0 where it is not known [-].
        trim_fast: Likewise airspeed_max; 0 where it is not known [-].
        climb_max: w_+, climb rate of thrust_max at V_c, in [m/s].
        sink_idle: w_0, sink rate of thrust_min at V_c, in [m/s].
        load_energy: R, energy rate per load factor above 1, in [m^2/s^3].
        pitch_min: In [rad].
        pitch_max: In [rad].
        pitch_time: T_theta in [s].
        pitch_slew: In [rad/s].
        thrust_slew: In [1/s].
    """

    cruise: float
    airspeed_min: float
    airspeed_max: float
    thrust_min: float = 0.0
    thrust_max: float = 1.0
    trim: float = 0.6
    trim_slow: float = 0.0
    trim_fast: float = 0.0
    climb_max: float = 5.0
    sink_idle: float = 2.0
    load_energy: float = 15.0
    pitch_min: float = -0.5
    pitch_max: float = 0.5
    pitch_time: float = 0.4
    pitch_slew: float = 1.0
    thrust_slew: float = 2.0


class FlownPath(NamedTuple):
    """What is measured.

    Attributes:
        time: In [s].
        path_angle: chi in [rad].
        airspeed: v, true, in [m/s].
        bank: phi in [rad].
        true_over_equivalent: Of the airspeed, by the density of the air [-].
    """

    time: float
    path_angle: float
    airspeed: float
    bank: float
    true_over_equivalent: float = 1.0


class EnergyLaw:
    """Follows the reference; what it is given need not be finite, what it gives always is.

    Args:
        limits: Of the aircraft.

    Attributes:
        path_angle: chi_r in [rad].
        airspeed: v_r in [m/s].
        pitch: Commanded last, in [rad].
        thrust: Commanded last, from 0 to 1 [-].
    """

    def __init__(self, limits: EnergyLimits) -> None:
        self._limits = limits
        self._time = -math.inf
        self.path_angle, self.airspeed = 0.0, limits.cruise
        self._path_rate = self._gain = 0.0
        self.pitch, self.thrust = 0.0, limits.trim
        self._incidence = self._force = 0.0  # I_theta and I_v
        self._pitch_full = self._thrust_full = 0  # 1 at the upper limit, -1 at the lower

    def begin(self, flown: FlownPath, pitch: float, thrust: float | None = None) -> None:
        """Begin from what is flown: the present path angle, airspeed, pitch and thrust.

        Args:
            flown: What is measured.
            pitch: Of the nose, measured, in [rad].
            thrust: At present, from 0 to 1 [-]; None where it is not known.
        """
        if not all(map(math.isfinite, (*flown, pitch))):
            return
        limits = self._limits
        self._time = flown.time
        self.path_angle, self.airspeed = flown.path_angle, self._allowed(flown.airspeed, flown)
        self._path_rate = self._gain = 0.0
        self.pitch = _clip(pitch, limits.pitch_min, limits.pitch_max)
        feed_forward = self._lift_angle(flown) + flown.path_angle
        self._incidence = _clip(pitch - feed_forward, -STALL, STALL)
        self._force = 0.0
        if thrust is not None and math.isfinite(thrust):
            self.thrust = _clip(thrust, limits.thrust_min, limits.thrust_max)

    def step(self, path_rate: float, gain: float, flown: FlownPath) -> tuple[float, float]:
        """Go on by the time since the last step.

        Args:
            path_rate: u_chi in [rad/s].
            gain: u_v in [m/s^2].
            flown: What is measured.

        Returns:
            Pitch of the nose in [rad] and thrust from 0 to 1 [-], both within their limits.
        """
        duration = flown.time - self._time
        if not all(map(math.isfinite, (path_rate, gain, *flown))) or duration <= 0.0:
            return self.pitch, self.thrust
        self._time = flown.time
        if duration > LONGEST_STEP:
            self.path_angle, self.airspeed = flown.path_angle, self._allowed(flown.airspeed, flown)
            duration = LONGEST_STEP
        jerk = self._lead(path_rate, gain, flown, duration)
        self.pitch = self._pitched(jerk, flown, duration)
        self.thrust = self._thrusted(flown, duration)
        return self.pitch, self.thrust

    def _lead(self, path_rate: float, gain: float, flown: FlownPath, duration: float) -> float:
        """Move the reference on; gives the rate of omega in [rad/s^2]."""
        before = self._path_rate
        self._path_rate += (path_rate - before) * followed(duration, PATH_LAG)
        self._gain += (gain - self._gain) * followed(duration, SPEED_LAG)
        # Where pitch or thrust is at its limit, the reference does not run away from the aircraft.
        if self._path_rate * self._pitch_full <= 0.0:
            self.path_angle += self._path_rate * duration
        if self._gain * self._thrust_full <= 0.0:
            self.airspeed += self._gain * duration
        low, high = flown.path_angle - PATH_WINDOW, flown.path_angle + PATH_WINDOW
        self.path_angle = _clip(self.path_angle, low, high)
        low, high = flown.airspeed - SPEED_WINDOW, flown.airspeed + SPEED_WINDOW
        asked = _clip(self.airspeed, low, high)
        self.airspeed = self._allowed(asked, flown)
        if (asked - self.airspeed) * self._gain > 0.0:
            self._gain = 0.0
        return (path_rate - self._path_rate) / PATH_LAG

    def _pitched(self, jerk: float, flown: FlownPath, duration: float) -> float:
        limits = self._limits
        lacking = self._lacking(flown)
        giving_way = _clip(lacking / (GRAVITY * SPEED_TIME), -GIVING_WAY, GIVING_WAY)
        error = self.path_angle - giving_way - flown.path_angle
        lead = (limits.pitch_time + LIFT_TIME) * self._path_rate
        lead += limits.pitch_time * LIFT_TIME * jerk
        asked = self.path_angle - giving_way + lead + PATH_GAIN * error
        asked += self._incidence + self._lift_angle(flown)
        self._pitch_full = (asked > limits.pitch_max) - (asked < limits.pitch_min)
        if error * self._pitch_full <= 0.0 and lacking == 0.0:
            learnt = self._incidence + PATH_INTEGRAL * error * duration
            self._incidence = _clip(learnt, -STALL, STALL)
        reach = limits.pitch_slew * duration
        return _slewed(asked, self.pitch, reach, limits.pitch_min, limits.pitch_max)

    def _thrusted(self, flown: FlownPath, duration: float) -> float:
        limits = self._limits
        error = self.airspeed - flown.airspeed
        climbing = GRAVITY * math.sin(self.path_angle)
        force = self._gain + climbing + error / SPEED_TIME + self._force
        energy = flown.airspeed * force + limits.load_energy * (_load(flown) - 1.0)
        trim = self._trim(flown)
        up, down = limits.thrust_max - trim, trim - limits.thrust_min
        if energy >= 0.0:
            asked = trim + up * energy / (GRAVITY * limits.climb_max)
        else:
            asked = trim + down * energy / (GRAVITY * limits.sink_idle)
        asked += (limits.thrust_max - asked) * _clip(self._lacking(flown) / SLOW, 0.0, 1.0)
        self._thrust_full = (asked > limits.thrust_max) - (asked < limits.thrust_min)
        if error * self._thrust_full <= 0.0:
            most = GRAVITY * limits.climb_max / max(flown.airspeed, limits.airspeed_min)
            learnt = self._force + SPEED_INTEGRAL * error * duration
            self._force = _clip(learnt, -most, most)
        reach = limits.thrust_slew * duration
        return _slewed(asked, self.thrust, reach, limits.thrust_min, limits.thrust_max)

    def _trim(self, flown: FlownPath) -> float:
        """Thrust for level flight, as ``PerformanceModel::getTrimThrottle`` has it."""
        limits = self._limits
        equivalent = flown.airspeed / flown.true_over_equivalent
        ratio = max(flown.true_over_equivalent, 1.0)
        trim = limits.trim
        if equivalent < limits.cruise and limits.trim_slow > 0.0:
            share = (limits.cruise - equivalent) / (limits.cruise - limits.airspeed_min)
            trim += min(share, 1.0) * (limits.trim_slow - trim)
        elif equivalent > limits.cruise and limits.trim_fast > 0.0:
            share = (equivalent - limits.cruise) / (limits.airspeed_max - limits.cruise)
            trim += min(share, 1.0) * (limits.trim_fast - trim)
        return _clip(trim * ratio, limits.thrust_min, limits.thrust_max)

    def _lift_angle(self, flown: FlownPath) -> float:
        """Angle of attack beyond that of cruise, as far as it raises the nose, in [rad]."""
        slowest = 0.5 * self._limits.airspeed_min
        equivalent = max(flown.airspeed / flown.true_over_equivalent, slowest)
        lift = _load(flown) * (self._limits.cruise / equivalent) ** 2
        angle = LIFT_ANGLE * (lift - 1.0) * math.cos(flown.bank)
        return _clip(angle, -STALL, STALL)

    def _airspeeds(self, flown: FlownPath) -> tuple[float, float]:
        """Least and greatest airspeed, true, in [m/s]; in a turn the least grows with the lift."""
        limits, ratio = self._limits, flown.true_over_equivalent
        most = limits.airspeed_max * ratio
        return min(limits.airspeed_min * ratio * math.sqrt(_load(flown)), most), most

    def _lacking(self, flown: FlownPath) -> float:
        """Airspeed below its least, positive, or above its greatest, negative, in [m/s]."""
        least, most = self._airspeeds(flown)
        return max(least - flown.airspeed, 0.0) - max(flown.airspeed - most, 0.0)

    def _allowed(self, airspeed: float, flown: FlownPath) -> float:
        return _clip(airspeed, *self._airspeeds(flown))


def _load(flown: FlownPath) -> float:
    """Load factor of a coordinated turn."""
    return min(1.0 / max(math.cos(flown.bank), 1.0 / LOAD_LIMIT), LOAD_LIMIT)


def _slewed(asked: float, before: float, reach: float, low: float, high: float) -> float:
    return _clip(_clip(asked, before - reach, before + reach), low, high)


def _clip(value: float, low: float, high: float) -> float:
    return min(max(value, low), high)
