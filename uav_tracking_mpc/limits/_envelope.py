r"""What the aircraft can fly, and which orbits that leaves it.

Three limits are coupled. A coordinated turn banks by :math:`\tan\phi = v u_\psi / g`, so the bank
limits the turn rate by the airspeed. Thrust less drag gives the specific force along the path,
:math:`f_{min}(v) \le g \sin\chi + u_v \le f_{max}(v)`: a climb and an acceleration share it. And
a drift c, the wind less the target's velocity, changes the relative speed round the orbit: along
the unit tangent t it is

.. math:: s = c \cdot t + \sqrt{V^2 - |c|^2 + (c \cdot t)^2}

with V and c horizontal, and the circle of radius d needs the turn rate
:math:`s^2 / (d (s - c \cdot t))`. That is greatest where t is along c:
:math:`(V + |c|)^2 / (d V)`.
"""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from uav_tracking_mpc.dynamics.orbit import Orbit

GRAVITY = 9.80665  # m/s^2, standard gravity
# An orbit that needs every bit of the bank leaves nothing to correct an error with.
TURN_RATE_SHARE = 0.95
# With the drift as fast as the aircraft there is no way back upwind.
DRIFT_SHARE = 0.9
# Path angle and airspeed approach their limits no faster than with this time constant [s]; inner
# loops have lags and dead times of 0.2 to 0.5 s.
APPROACH_TIME = 0.5


@dataclass(frozen=True)
class Envelope:
    """Limits of the aircraft and of where it may fly.

    Attributes:
        airspeed_min: Least airspeed in [m/s], at least 0.
        airspeed_max: Greatest airspeed in [m/s].
        path_angle_min: Steepest descent in [rad], from -pi/2 to 0.
        path_angle_max: Steepest climb in [rad], from 0 to pi/2.
        bank_max: Greatest bank angle of a coordinated turn in [rad], at most pi/2.
        yaw_rate_max: Greatest abs(u_psi) in [rad/s].
        pitch_rate_max: Greatest abs(u_chi) in [rad/s].
        acceleration_min: Least u_v in [m/s^2], negative.
        acceleration_max: Greatest u_v in [m/s^2], positive.
        force_min: Least specific force (thrust less drag, over mass) at ``airspeed_min`` and at
            ``airspeed_max`` in [m/s^2], linear between.
        force_max: The greatest, likewise.
        height_min: Least z in ``map`` in [m]; -inf for none.
        distance_min: Least distance to the target in [m]; 0 for none.
        fence_radius: Of the horizontal circle not to be left, in [m]; 0 for none.
        fence_centre: (x, y) of its centre in ``map`` in [m].

    Raises:
        ValueError: A value is outside these ranges, or a lower limit is not below its upper one.
    """

    airspeed_min: float
    airspeed_max: float
    path_angle_min: float
    path_angle_max: float
    bank_max: float
    yaw_rate_max: float
    pitch_rate_max: float
    acceleration_min: float
    acceleration_max: float
    force_min: tuple[float, float]
    force_max: tuple[float, float]
    height_min: float = -math.inf
    distance_min: float = 0.0
    fence_radius: float = 0.0
    fence_centre: tuple[float, float] = (0.0, 0.0)

    def __post_init__(self) -> None:
        """Refuse limits that contradict themselves."""
        for field in dataclasses.fields(self):
            value = getattr(self, field.name)
            if not (np.all(np.isfinite(value)) or (field.name == "height_min" and value < 0.0)):
                raise ValueError(f"envelope {field.name} is {value}, must be finite")
        right = math.pi / 2.0
        for name, fits, allowed in (
            ("airspeed_min", self.airspeed_min >= 0.0, "at least 0"),
            ("airspeed_max", self.airspeed_max > self.airspeed_min, "above airspeed_min"),
            ("path_angle_min", -right <= self.path_angle_min < 0.0, "from -pi/2 to below 0"),
            ("path_angle_max", 0.0 < self.path_angle_max <= right, "above 0, at most pi/2"),
            ("bank_max", 0.0 < self.bank_max <= right, "above 0, at most pi/2"),
            ("yaw_rate_max", self.yaw_rate_max > 0.0, "positive"),
            ("pitch_rate_max", self.pitch_rate_max > 0.0, "positive"),
            ("acceleration_min", self.acceleration_min < 0.0, "negative"),
            ("acceleration_max", self.acceleration_max > 0.0, "positive"),
            ("force_max", np.all(np.subtract(self.force_max, self.force_min) > 0.0), "> force_min"),
            ("distance_min", self.distance_min >= 0.0, "at least 0"),
            ("fence_radius", self.fence_radius >= 0.0, "at least 0"),
        ):
            if not fits:
                raise ValueError(f"envelope {name} is {getattr(self, name)}, must be {allowed}")

    def turn_rate_max(self, airspeed: float) -> float:
        """Greatest abs(u_psi) in [rad/s] at an airspeed [m/s]: the bank's or the yaw rate's."""
        bank = GRAVITY * math.tan(self.bank_max)
        if not airspeed * self.yaw_rate_max > bank:  # also at 0, where the bank allows any
            return self.yaw_rate_max
        return bank / airspeed

    def force_limits(self, airspeed: float) -> tuple[float, float]:
        """Least and greatest specific force g sin(chi) + u_v in [m/s^2] at an airspeed [m/s]."""
        span = self.airspeed_max - self.airspeed_min
        share = min(1.0, max(0.0, (airspeed - self.airspeed_min) / span))
        lower, upper = (
            ends[0] + share * (ends[1] - ends[0]) for ends in (self.force_min, self.force_max)
        )
        return lower, upper

    def path_angle_limits(self, airspeed: float) -> tuple[float, float]:
        """Least and greatest path angle in [rad] at which an airspeed [m/s] can be held.

        Where not even level flight can be held, the limit is the path angle of least loss.
        """
        lower, upper = self.force_limits(airspeed)
        return (
            min(self.path_angle_max, max(self.path_angle_min, _arcsine(lower / GRAVITY))),
            max(self.path_angle_min, min(self.path_angle_max, _arcsine(upper / GRAVITY))),
        )

    def clip(self, inputs: ArrayLike, airspeed: float, path_angle: float) -> NDArray[np.float64]:
        """Nearest inputs that the aircraft can fly in its present state.

        Path angle and airspeed are let approach their limits as exp(-t / 0.5 s), and are led back
        if they are outside. Near the least airspeed this flattens a climb that the thrust cannot
        sustain. Where limits contradict each other, those on the inputs themselves win, then the
        specific force.

        Args:
            inputs: (u_psi, u_chi, u_v), shape (3,); what is no number counts as 0.
            airspeed: v in [m/s].
            path_angle: chi in [rad].

        Returns:
            Finite inputs, shape (3,).
        """
        turn, pitch, acceleration = (
            0.0 if math.isnan(value) else float(value) for value in np.asarray(inputs, float)
        )
        airspeed = airspeed if math.isfinite(airspeed) else self.airspeed_min
        path_angle = path_angle if math.isfinite(path_angle) else 0.0
        turn_rate_max = self.turn_rate_max(airspeed)
        force_min, force_max = self.force_limits(airspeed)
        slowing = max(self.acceleration_min, (self.airspeed_min - airspeed) / APPROACH_TIME)
        speeding = min(self.acceleration_max, (self.airspeed_max - airspeed) / APPROACH_TIME)
        # Steeper, and the force could not keep the airspeed inside its limits.
        steepest_descent = max(self.path_angle_min, _arcsine((force_min - speeding) / GRAVITY))
        steepest_climb = min(self.path_angle_max, _arcsine((force_max - slowing) / GRAVITY))
        pitch = min(pitch, (steepest_climb - path_angle) / APPROACH_TIME)
        pitch = max(pitch, (steepest_descent - path_angle) / APPROACH_TIME)
        weight = GRAVITY * math.sin(path_angle)
        acceleration = min(max(acceleration, slowing), speeding)
        acceleration = min(max(acceleration, force_min - weight), force_max - weight)
        return np.array(
            [
                min(max(turn, -turn_rate_max), turn_rate_max),
                min(max(pitch, -self.pitch_rate_max), self.pitch_rate_max),
                min(max(acceleration, self.acceleration_min), self.acceleration_max),
            ]
        )

    def smallest_radius(self, airspeed: float, drift: ArrayLike) -> float:
        """Radius in [m] of the sharpest circle that the turn rate allows; inf if there is none.

        Args:
            airspeed: v in [m/s], held.
            drift: c, shape (3,), in [m/s].
        """
        level, along = _level_speeds(airspeed, drift)
        if level <= along:
            return math.inf
        return (level + along) ** 2 / (level * self.turn_rate_max(airspeed))

    def refusal(self, orbit: Orbit, drift: ArrayLike) -> str:
        """Why an orbit cannot be flown and which one can, in words; empty if it can be flown.

        Args:
            orbit: What is asked for; its speed is an airspeed.
            drift: c, shape (3,), in [m/s].
        """
        reason = self._reason(orbit, drift)
        if not reason:
            return ""
        try:
            nearest = self.nearest_orbit(orbit, drift)
        except ValueError as error:
            return f"{reason}; {error}"
        words = f"a range of {nearest.range:.1f} m"
        if nearest.speed != orbit.speed:
            words += f" and an airspeed of {nearest.speed:.1f} m/s"
        return f"{reason}; the nearest orbit that can be flown has {words}"

    def nearest_orbit(self, orbit: Orbit, drift: ArrayLike) -> Orbit:
        """Orbit that can be flown at the same altitude: nearest airspeed, then least range.

        Raises:
            ValueError: In this drift no airspeed will do.
        """
        speeds = np.append(
            np.linspace(self.airspeed_min, self.airspeed_max, 201),
            min(max(orbit.speed, self.airspeed_min), self.airspeed_max),
        )
        for speed in speeds[np.argsort(np.abs(speeds - orbit.speed), kind="stable")]:
            if speed > 0.0 and not self._speed_reason(float(speed), drift):
                break
        else:
            strength = float(np.linalg.norm(np.asarray(drift, dtype=float)))
            raise ValueError(f"no orbit can be flown in a drift of {strength:.1f} m/s")
        radius = self.smallest_radius(float(speed), drift) / TURN_RATE_SHARE
        if orbit.radius < radius:
            # A little more, for rounding in d = sqrt(r^2 - z^2).
            least = math.hypot(radius * (1.0 + 1e-6), orbit.altitude)
        else:
            least = orbit.range
        return dataclasses.replace(orbit, range=max(least, self.distance_min), speed=float(speed))

    def _reason(self, orbit: Orbit, drift: ArrayLike) -> str:
        reason = self._speed_reason(orbit.speed, drift)
        if reason:
            return reason
        words = f"an orbit of {orbit.range:.1f} m range at {orbit.speed:.3g} m/s"
        if orbit.range < self.distance_min:
            return f"{words} is nearer to the target than the {self.distance_min:.1f} m allowed"
        allowed = self.turn_rate_max(orbit.speed)
        smallest = self.smallest_radius(orbit.speed, drift)
        if orbit.radius * TURN_RATE_SHARE >= smallest:
            return ""
        along = _level_speeds(orbit.speed, drift)[1]
        needed = allowed * smallest / orbit.radius if orbit.radius > 0.0 else math.inf
        where = f" where the drift of {along:.1f} m/s follows the flight" if along else ""
        limit = "the yaw rate's limit"
        if allowed < self.yaw_rate_max:
            limit = f"bank {math.degrees(self.bank_max):.3g} deg"
        return (
            f"{words} needs a turn rate of {needed:.3g} rad/s{where}, {limit} allows "
            f"{allowed:.3g} rad/s, {1.0 - TURN_RATE_SHARE:.0%} of it kept to correct with"
        )

    def _speed_reason(self, airspeed: float, drift: ArrayLike) -> str:
        """Why an airspeed cannot be held on any level orbit in this drift; empty if it can."""
        if not self.airspeed_min <= airspeed <= self.airspeed_max:
            return (
                f"an airspeed of {airspeed:.3g} m/s is not between {self.airspeed_min:.3g} and "
                f"{self.airspeed_max:.3g} m/s"
            )
        level, along = _level_speeds(airspeed, drift)
        if along >= DRIFT_SHARE * level:
            return (
                f"a drift of {along:.1f} m/s is too much for an airspeed of {airspeed:.3g} m/s, "
                f"{DRIFT_SHARE:.0%} of which it may reach"
            )
        # To stay level with the target the air velocity makes up for the vertical drift.
        path_angle = _arcsine(-float(np.asarray(drift, dtype=float)[2]) / airspeed)
        lower, upper = self.path_angle_limits(airspeed)
        if not lower <= path_angle <= upper:
            return (
                f"an airspeed of {airspeed:.3g} m/s at a path angle of "
                f"{math.degrees(path_angle):.2g} deg cannot be held, only from "
                f"{math.degrees(lower):.2g} to {math.degrees(upper):.2g} deg"
            )
        return ""


def _level_speeds(airspeed: float, drift: ArrayLike) -> tuple[float, float]:
    """Horizontal air speed that is left beside the vertical drift, and the horizontal drift."""
    x, y, z = (float(value) for value in np.asarray(drift, dtype=float))
    return math.sqrt(max(0.0, airspeed * airspeed - z * z)), math.hypot(x, y)


def _arcsine(sine: float) -> float:
    return math.asin(min(1.0, max(-1.0, sine)))
