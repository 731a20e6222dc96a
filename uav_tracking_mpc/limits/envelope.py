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

r"""All limits together: what the aircraft can fly, and which orbits that leaves it.

Limits that meet on one input are merged smoothly: plans like to stay where one limit takes over
from another, and a kink there would leave Newton's method without a derivative.

Three limits are coupled. A bank limits the turn rate by the airspeed. The specific force is shared
by a climb and an acceleration. And a drift changes the relative speed round the orbit, so that the
sharpest turn is flown where it follows the flight
(:func:`~uav_tracking_mpc.dynamics.orbit.sharpest_turn`).
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable, Sequence
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from uav_tracking_mpc.dynamics.air import GRAVITY
from uav_tracking_mpc.dynamics.orbit import (
    DRIFT_SHARE,
    Orbit,
    horizontal,
    level_speed,
    sharpest_turn,
)
from uav_tracking_mpc.limits import LIMIT, Bound, Limit, Motion, OrbitShape
from uav_tracking_mpc.limits.airspeed import Acceleration, Airspeed, Force, arcsine
from uav_tracking_mpc.limits.climb import PathAngle, PitchRate
from uav_tracking_mpc.limits.turn import Bank, YawRate

# rad/s, rad/s, m/s^2 over which limits merge
BLENDS = {"turn_rate": 0.02, "path_angle_rate": 0.02, "acceleration": 0.2}
# -, of a blend, that an input can span where limits contradict each other: one of the input itself,
# the same either way, wins, then that named first.
LEAST_SPAN = 0.5


def input_span(
    limits: Sequence[Limit], numbers: Sequence[Any], motion: Motion, xp: ModuleType
) -> tuple[list[Any], list[Any]]:
    """Middle and half width of what each of (u_psi, u_chi, u_v) can be.

    Args:
        limits: All that hold.
        numbers: What each is told, shape (k,) or (k, n), see :meth:`Limit.numbers`.
        motion: In which the inputs are flown: scalars, or arrays of shape (n,).
        xp: ``casadi`` for expressions, ``numpy`` for numbers or arrays of them.

    Returns:
        Three values each, in [rad/s, rad/s, m/s^2], scalar or of shape (n,).
    """
    bounds = [limit.inputs(motion, told, xp) for limit, told in zip(limits, numbers, strict=True)]
    middle, half = [], []
    for name, blend in BLENDS.items():
        spans = [bound[name] for bound in bounds if name in bound]
        spans.sort(key=lambda span: span[0] is not None)
        upper = _merged([span[1] for span in spans], blend, xp)
        if all(span[0] is None for span in spans):
            middle.append(0.0 * upper)
            half.append(upper)
            continue
        negative = [span[1] if span[0] is None else -span[0] for span in spans]
        own = _merged([span[1] for span in spans if span[0] is None] or [spans[0][1]], blend, xp)
        lower = xp.fmin(-_merged(negative, blend, xp), own - LEAST_SPAN * blend)
        upper = xp.fmax(upper, lower + LEAST_SPAN * blend)
        middle.append(0.5 * (lower + upper))
        half.append(0.5 * (upper - lower))
    return middle, half


def _merged(values: list[Any], blend: float, xp: ModuleType) -> Any:
    least = values[0]
    for value in values[1:]:
        least = smooth_minimum(least, value, blend, xp)
    return least


def smooth_minimum(a: Any, b: Any, blend: float, xp: ModuleType) -> Any:
    """Smooth minimum, never above min(a, b), at most blend / 2 below it (where a = b).

    Args:
        a: In any unit [SI], scalar or any shape, or a symbol; so is b.
        b: The other value in [SI], any shape.
        blend: Difference of a and b over which they merge, in [SI].
        xp: ``casadi`` or ``numpy``.
    """
    return 0.5 * (a + b - xp.sqrt((a - b) ** 2 + blend**2))


# s, the least time constant with which path angle and airspeed approach their limits: inner loops
# have lags and dead times of 0.2 to 0.5 s.
APPROACH_TIME = 0.5


class Envelope:
    """Limits of the aircraft and of where it may fly.

    Args:
        extensions: Classes of limits beyond those that come with the project.
        values: Parameters of the limits by name; what is missing takes its default.

    Attributes:
        limits: All of them.

    Raises:
        ParameterError: A value that is not allowed, or limits that contradict each other.
        TypeError: A parameter that no limit has.
    """

    def __init__(self, extensions: Iterable[type[Limit]] = (), **values: Any) -> None:
        self._values: dict[str, Any] = {}
        limits = []
        for kind in (*LIMIT.own().values(), *extensions):
            own = {
                field.name: values.get(field.name, field.default)
                for field in dataclasses.fields(kind)
            }
            self._values.update(own)
            limits.append(kind(**own))
        if unknown := values.keys() - self._values.keys():
            raise TypeError(f"no limit has the parameters {', '.join(sorted(unknown))}")
        self.limits: tuple[Limit, ...] = tuple(limits)
        self._airspeed, self._path_angle, self._bank, self._yaw_rate, self._force = (
            self.find(kind) for kind in (Airspeed, PathAngle, Bank, YawRate, Force)
        )
        self._pitch_rate, self._acceleration = self.find(PitchRate), self.find(Acceleration)

    def __getattr__(self, name: str) -> Any:
        """A limit's parameter by its name."""
        values = self.__dict__.get("_values", {})
        if name in values:
            return values[name]
        raise AttributeError(f"no limit has a parameter {name!r}")

    def find(self, kind: type[Any]) -> Any:
        """The limit of a class.

        Args:
            kind: Class of the limit.
        """
        return next(limit for limit in self.limits if type(limit) is kind)

    def turn_rate_max(self, airspeed: float) -> float:
        """Greatest abs(u_psi) in [rad/s]: the bank's or the yaw rate's.

        Args:
            airspeed: v in [m/s].
        """
        return min(self._yaw_rate.yaw_rate_max, self._bank.turn_rate_max(airspeed))

    def force_limits(self, airspeed: float) -> tuple[float, float]:
        """Least and greatest specific force g sin(chi) + u_v in [m/s^2].

        Args:
            airspeed: v in [m/s].
        """
        return self._force.force_limits(airspeed)

    def path_angle_limits(self, airspeed: float) -> tuple[float, float]:
        """Least and greatest path angle in [rad] at which an airspeed can be held.

        Where not even level flight can be held, the limit is the path angle of least loss.

        Args:
            airspeed: v in [m/s].
        """
        steepest, most = self._path_angle.path_angle_min, self._path_angle.path_angle_max
        lower, upper = (arcsine(force / GRAVITY) for force in self.force_limits(airspeed))
        return min(most, max(steepest, lower)), max(steepest, min(most, upper))

    def clip(self, inputs: ArrayLike, airspeed: float, path_angle: float) -> NDArray[np.float64]:
        """Nearest inputs that the aircraft can fly in its present state.

        Path angle and airspeed approach their limits as exp(-t / 0.5 s), and are led back if they
        are outside. Near the least airspeed this flattens a climb that the thrust cannot sustain.
        Where limits contradict each other, those on the inputs themselves win, then the specific
        force.

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
        speeds, angles, own = self._airspeed, self._path_angle, self._acceleration
        airspeed = airspeed if math.isfinite(airspeed) else speeds.airspeed_min
        path_angle = path_angle if math.isfinite(path_angle) else 0.0
        turn_rate_max = self.turn_rate_max(airspeed)
        pitch_rate_max = self._pitch_rate.pitch_rate_max
        force_min, force_max = self.force_limits(airspeed)
        slowing = max(own.acceleration_min, (speeds.airspeed_min - airspeed) / APPROACH_TIME)
        speeding = min(own.acceleration_max, (speeds.airspeed_max - airspeed) / APPROACH_TIME)
        # Steeper, and the force could not keep the airspeed inside its limits.
        descent = max(angles.path_angle_min, arcsine((force_min - speeding) / GRAVITY))
        climb = min(angles.path_angle_max, arcsine((force_max - slowing) / GRAVITY))
        pitch = min(pitch, (climb - path_angle) / APPROACH_TIME)
        pitch = max(pitch, (descent - path_angle) / APPROACH_TIME)
        weight = GRAVITY * math.sin(path_angle)
        acceleration = min(max(acceleration, slowing), speeding)
        acceleration = min(max(acceleration, force_min - weight), force_max - weight)
        return np.array(
            [
                min(max(turn, -turn_rate_max), turn_rate_max),
                min(max(pitch, -pitch_rate_max), pitch_rate_max),
                min(max(acceleration, own.acceleration_min), own.acceleration_max),
            ]
        )

    def smallest_radius(self, airspeed: float, drift: ArrayLike) -> float:
        """Radius in [m] of the sharpest circle that the turn rate allows; inf if there is none.

        Args:
            airspeed: v in [m/s], held.
            drift: c, shape (3,), in [m/s].
        """
        level, along = level_speed(airspeed, drift), horizontal(drift)
        if level <= along:
            return math.inf
        return sharpest_turn(1.0, level, along) / self.turn_rate_max(airspeed)

    def refusal(self, orbit: Orbit, drift: ArrayLike, ground: float | None = None) -> str:
        """Why an orbit cannot be flown and which one can, in words; empty if it can be flown.

        Args:
            orbit: What is asked for; its speed is an airspeed.
            drift: c, shape (3,), in [m/s].
            ground: Height of the target in ``map`` in [m]; None where it is not known.
        """
        least = self.height_min
        if ground is not None and Bound(ground + orbit.altitude, lower=least).passed():
            return (
                f"an altitude of {orbit.altitude:.4g} m above a target at {ground:.4g} m is below "
                f"the least height of {least:.4g} m; the least altitude is {least - ground:.4g} m"
            )
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

        Args:
            orbit: What is asked for.
            drift: c, shape (3,), in [m/s].

        Raises:
            ValueError: In this drift no airspeed will do.
        """
        least, most = self._airspeed.airspeed_min, self._airspeed.airspeed_max
        speeds = np.append(np.linspace(least, most, 201), min(max(orbit.speed, least), most))
        for speed in speeds[np.argsort(np.abs(speeds - orbit.speed), kind="stable")].tolist():
            if speed > 0.0 and not self._speed_reason(
                dataclasses.replace(orbit, speed=speed), drift
            ):
                break
        else:
            strength = float(np.linalg.norm(np.asarray(drift, dtype=float)))
            raise ValueError(f"no orbit can be flown in a drift of {strength:.1f} m/s")
        radius = self._least_radius(speed, drift)
        distance = orbit.range
        if orbit.radius < radius:
            # A little more, for rounding in d = sqrt(r^2 - z^2).
            distance = math.hypot(radius * (1.0 + 1e-6), orbit.altitude)
        return dataclasses.replace(orbit, range=max(distance, self.distance_min), speed=speed)

    def _reason(self, orbit: Orbit, drift: ArrayLike) -> str:
        reason = self._speed_reason(orbit, drift)
        for limit in self.limits:
            reason = reason or limit.refusal(orbit, drift)
        return reason or self._turn_reason(orbit, drift)

    def _turn_reason(self, orbit: Orbit, drift: ArrayLike) -> str:
        least = self._least_radius(orbit.speed, drift)
        if orbit.radius >= least:
            return ""
        allowed, along = self.turn_rate_max(orbit.speed), horizontal(drift)
        planned = sharpest_turn(least, orbit.speed, along)
        needed = planned * least / orbit.radius if orbit.radius > 0.0 else math.inf
        where = f" where the drift of {along:.1f} m/s follows the flight" if along else ""
        limit = "the yaw rate's limit"
        if allowed < self._yaw_rate.yaw_rate_max:
            limit = f"bank {math.degrees(self._bank.bank_max):.3g} deg"
        return (
            f"an orbit of {orbit.range:.1f} m range at {orbit.speed:.3g} m/s needs a turn rate of "
            f"{needed:.3g} rad/s{where}, {limit} allows {allowed:.3g} rad/s, "
            f"{1.0 - planned / allowed:.0%} of it kept to correct with"
        )

    def _least_radius(self, airspeed: float, drift: ArrayLike) -> float:
        """Radius in [m] of the sharpest circle on which a plan may end, by the limits."""
        unit = OrbitShape(1.0, 0.0, airspeed, 1.0, horizontal(drift))
        turns = (self._bank, self._yaw_rate)  # each tells how many times the unit circle is passed
        return max(
            float(limit.orbit(unit, limit.numbers(np.zeros((1, 3)))[0], np).value)
            for limit in turns
        )

    def _speed_reason(self, orbit: Orbit, drift: ArrayLike) -> str:
        """Why the airspeed cannot be held on any level orbit in this drift; empty if it can."""
        airspeed, along = orbit.speed, horizontal(drift)
        reason = self._airspeed.refusal(orbit, drift)
        if reason:
            return reason
        if along > DRIFT_SHARE * level_speed(airspeed, drift):
            return (
                f"a drift of {along:.1f} m/s is too much for an airspeed of {airspeed:.3g} m/s, "
                f"{DRIFT_SHARE:.0%} of which it may reach"
            )
        # To stay level with the target the air velocity makes up for the vertical drift.
        path_angle = arcsine((0.0 - float(np.asarray(drift, dtype=float)[2])) / airspeed)
        lower, upper = self.path_angle_limits(airspeed)
        if not lower <= path_angle <= upper:
            return (
                f"an airspeed of {airspeed:.3g} m/s at a path angle of "
                f"{math.degrees(path_angle):.2g} deg cannot be held, only from "
                f"{math.degrees(lower):.2g} to {math.degrees(upper):.2g} deg"
            )
        return ""
