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

r"""NPFG: the path-following law that PX4 flies, about a target that may move.

The nonlinear path-following guidance of T. Stastny, R. Siegwart, "On Flying Backwards: Preventing
Run-away of Small, Low-speed, Fixed-wing UAVs in Strong Winds", IROS 2019, arXiv:1908.01381, as
PX4's class ``NPFG`` has it (``src/lib/npfg/npfg.cpp``; in 2025 its functions went to
``DirectionalGuidance`` and ``CourseToAirspeedRefMapper`` beside it), written anew here. Names in
parentheses are those functions; the constants are the defaults of PX4's parameters. PX4's wind
becomes the drift c and its ground velocity becomes w, the velocity relative to the target; e is the
signed distance outside the circle of radius R, d the distance to its centre, t its tangent in the
sense of the orbit, and V the horizontal airspeed.

The bearing b, the wanted direction of w, turns from the shortest way to the circle into its tangent
(``trackErrorBound``, ``lookAheadAngle``, ``bearingVec``):

.. math::
    \lambda = \frac{\pi}{2} \left(1 - \min\left(\frac{|e|}{|w| \zeta T}, 1\right)\right)^2, \qquad
    b = -\mathrm{sign}(e) \cos\lambda\, u + \sin\lambda\, t

with u from the target to the aircraft. With n 90 deg to the left of b, the reference of the air
velocity (``refAirVelocity``, ``solveWindTriangle``) has the airspeed

.. math::
    V_{ref} = \mathrm{clip}\left(\sqrt{\max(s_{min} - c \cdot b, 0)^2 + (c \cdot n)^2},
              v_d, v_{max}\right)

which keeps a speed of s_min along the bearing while v_max allows it, and makes the relative
velocity follow b. Where no air velocity of this size does, the mitigation law
(``infeasibleAirVelRef``) lets the aircraft be blown away as slowly as possible. The lateral
acceleration (``lateralAccel``, ``lateralAccelFF``) is that of the heading error eta, at most
90 deg, and that of the circle, which fades with the distance to it and with the feasibility f of b
and t (``bearingFeasibility``):

.. math::
    a = \frac{4 \pi \zeta}{T} V \sin\eta + f_b f_t \sin^2\lambda\,
        V \left(1 + \frac{c \cdot t}{\sqrt{V^2 - (c \cdot n_t)^2}}\right)
        \frac{\max(w \cdot t, 0)}{d}

Near a straight path in still air the error then swings with the period T and the damping zeta. T
has a lower bound from the roll lag and an upper one from curvature in wind (``adaptPeriod``). Three
things of PX4 are left out: the limit on the rate of its roll setpoint, 90 deg/s, since a law here
has no memory and the lag of the aircraft smooths what it asks for; the regulation of
``refAirVelocity`` against the bearing, which a minimum ground speed above zero never reaches; and
the track keeping (NPFG_GSP_MAX_TK), which asks for at most 5 m/s along the bearing where the
minimum ground speed asks for 5 m/s anyway.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.dynamics.orbit import Orbit
from uav_tracking_mpc.estimation.situation import Situation
from uav_tracking_mpc.laws import SPEED_GAIN, GuidanceLaw, altitude_hold
from uav_tracking_mpc.limits.envelope import Envelope

# Defaults of PX4's parameters, fw_path_navigation_params.c and fw_lat_long_params.yaml.
PERIOD = 10.0  # s, NPFG_PERIOD
DAMPING = 0.7  # -, NPFG_DAMPING
ROLL_TIME = 0.5  # s, NPFG_ROLL_TC
PERIOD_SAFETY = 1.5  # -, NPFG_PERIOD_SF
GROUND_SPEED_MIN = 5.0  # m/s, FW_GND_SPD_MIN
# Constants of npfg.hpp.
AIRSPEED_BUFFER = 1.5  # m/s, AIRSPEED_BUFFER: over which feasibility fades
RADIUS_MIN = 0.5  # m, MIN_RADIUS
SMALL = 1e-6  # -, NPFG_EPSILON: tolerance of what divides


class NPFGLoiter(GuidanceLaw):
    """Loiter law of PX4 about a target.

    Args:
        orbit: What to fly.
        envelope: What can be flown.
        period: T in [s].
        damping: zeta, [-].
    """

    name = "npfg"

    def __init__(
        self, orbit: Orbit, envelope: Envelope, period: float = PERIOD, damping: float = DAMPING
    ) -> None:
        super().__init__(orbit, envelope)
        self._period = period
        self._damping = damping

    def inputs(self, situation: Situation) -> NDArray[np.float64]:
        """See :meth:`GuidanceLaw.inputs`."""
        path_angle, speed = situation.path_angle, situation.airspeed
        lateral, reference = self.guide(situation)
        # The bank turns the air velocity: a = v u_psi.
        turn_rate = lateral / max(speed, 0.1 * self.orbit.speed)
        climb, acceleration = altitude_hold(self.orbit, self.envelope, situation)
        acceleration += SPEED_GAIN * (reference - self.orbit.speed)
        return self.envelope.clip([turn_rate, climb, acceleration], speed, path_angle)

    def guide(self, situation: Situation) -> tuple[float, float]:
        """Lateral acceleration and airspeed asked for (``NPFG::guideToPath``).

        Args:
            situation: Aircraft, target and drift now.

        Returns:
            (a, V_ref) in [m/s^2, m/s]; a is positive to the left, V_ref at least v_d.
        """
        x, y, _ = situation.offset.tolist()
        wx, wy, _ = situation.relative_velocity.tolist()
        # Horizontal vectors are complex numbers: East is real, North imaginary.
        drift = complex(*situation.drift.tolist()[:2])
        air = complex(*situation.air_velocity.tolist()[:2])
        relative, airspeed = complex(wx, wy), _norm(air)
        # Over the target the direction of the flight stands for that from the target.
        distance = math.hypot(x, y)
        outward = _unit(complex(x, y) if distance > 0.1 else relative)
        tangent = 1j * outward * self.sense
        error = distance - self.orbit.radius

        on_track = _feasibility(drift, tangent, airspeed)
        period = self._adapted_period(_norm(relative), airspeed, _norm(drift), abs(error), on_track)
        angle = self._look_ahead(abs(error), _norm(relative), period)
        inward = outward * (-1.0 if error > 0.0 else 1.0)
        bearing = inward * math.cos(angle) + tangent * math.sin(angle)
        proximity = math.sin(angle) ** 2
        feasible = on_track * _feasibility(drift, bearing, airspeed)

        reference, wanted = _air_velocity(
            drift, bearing, self.orbit.speed, self.envelope.airspeed_max
        )
        # Beyond 90 deg of heading error the acceleration stays at its greatest (lateralAccel).
        aim = _unit(wanted)
        sine = _across(aim, _unit(air))
        if _along(air, aim) < 0.0:
            sine = math.copysign(1.0, sine)
        lateral = 4.0 * math.pi * self._damping / period * airspeed * sine

        # The circle's turn, as if the aircraft were on it without heading error (lateralAccelFF).
        along, across = _along(drift, tangent), _across(drift, tangent)
        speed_ratio = 1.0 + along / max(_leg(airspeed, across), SMALL)
        rate = self.sense * max(_along(relative, tangent), 0.0) / max(distance, RADIUS_MIN)
        return lateral + feasible * proximity * airspeed * speed_ratio * rate, reference

    def _adapted_period(
        self, ground: float, airspeed: float, wind: float, error: float, on_track: float
    ) -> float:
        """T kept above what the roll lag, below what curvature in wind allows (adaptPeriod)."""
        zeta = self._damping
        # windFactor, times the turn rate of the circle in still air
        ratio = min(wind / max(airspeed, SMALL), 1.0)
        rate = airspeed / self.orbit.radius * 2.0 * (1.0 - math.sqrt(1.0 - ratio))
        straight = curved = math.pi * ROLL_TIME / zeta  # periodLowerBound
        if rate >= SMALL and zeta >= 0.5:
            curved = 4.0 * math.pi * ROLL_TIME * zeta * on_track + (1.0 - on_track) * straight
        straight, curved = PERIOD_SAFETY * straight, PERIOD_SAFETY * curved
        proximity = math.sin(self._look_ahead(error, ground, straight)) ** 2
        lower = curved * proximity + straight * (1.0 - proximity)
        period = max(lower, self._period)
        upper = math.inf
        if rate * on_track > SMALL:
            upper = 4.0 * math.pi * zeta / (rate * on_track)  # periodUpperBound
        if period > upper:
            period = max(lower, upper) * proximity + period * (1.0 - proximity)
        return period

    def _look_ahead(self, error: float, ground: float, period: float) -> float:
        """Angle of the bearing from the shortest way to the circle (lookAheadAngle)."""
        # trackErrorBound: smooth where the ground speed falls below 1 m/s
        speed = ground if ground > 1.0 else 0.5 * (ground * ground + 1.0)
        share = min(error / (speed * self._damping * period), 1.0)
        return 0.5 * math.pi * (1.0 - share) * (1.0 - share)


def _norm(vector: complex) -> float:
    return math.hypot(vector.real, vector.imag)


def _unit(vector: complex) -> complex:
    """Direction of a vector; North where it has none, as PX4 chooses."""
    norm = _norm(vector)
    return vector * (1.0 / norm) if norm > SMALL else 1j


def _along(vector: complex, direction: complex) -> float:
    return (direction.conjugate() * vector).real


def _across(vector: complex, direction: complex) -> float:
    """Component of a vector to the left of a direction."""
    return (direction.conjugate() * vector).imag


def _leg(hypotenuse: float, other: float) -> float:
    """Second leg of a right triangle, 0 where there is none (projectAirspOnBearing)."""
    return math.sqrt(max(hypotenuse * hypotenuse - other * other, 0.0))


def _feasibility(drift: complex, bearing: complex, airspeed: float) -> float:
    """1 where the air velocity can make up for the drift, 0 where not (bearingFeasibility)."""
    against = _norm(drift) if _along(drift, bearing) < 0.0 else abs(_across(drift, bearing))
    share = min(max((airspeed - against) / AIRSPEED_BUFFER, 0.0), 1.0)
    return math.sin(0.5 * math.pi * share) ** 2


def _air_velocity(
    drift: complex, bearing: complex, nominal: float, most: float
) -> tuple[float, complex]:
    """Airspeed, and the air velocity that follows a bearing with it (refAirVelocity)."""
    along, across = _along(drift, bearing), _across(drift, bearing)
    needed = math.hypot(max(GROUND_SPEED_MIN - along, 0.0), across)
    # In this order a drift that is no number leaves the nominal airspeed.
    airspeed = min(max(nominal, needed), most)
    if abs(across) <= airspeed and (along > 0.0 or _norm(drift) < airspeed):
        leg = _leg(airspeed, across)
        return airspeed, bearing * leg - 1j * bearing * across
    return airspeed, bearing * _leg(_norm(drift), airspeed) - drift
