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

"""The airspeed that belongs to a measurement; without one the air is taken as still.

An airspeed that comes by itself arrives after the state that it belongs to, so the first state has
none. It is awaited for a time before it counts as not measured. For the same reason the first state
after a gap goes by the airspeed from before the gap.
"""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.estimation.flight_path import (
    LEAST_AIRSPEED,
    QUICK_CLIMB,
    SLOW_CLIMB,
    FlightPath,
)
from uav_tracking_mpc.estimation.measurement import Axis, Measurement, MeasurementError
from uav_tracking_mpc.estimation.motion_check import CONTRARY_TIME, RETURN, STALE, WINDOW
from uav_tracking_mpc.estimation.sensor_health import CODE, OFF, SILENT, STUCK, USED
from uav_tracking_mpc.estimation.state_gate import NOISE_MULTIPLE

SLOW = 0.1  # m/s over ground, below which the body's axis tells where the vehicle goes
GUSTS = 5.0  # m/s, by which an airspeed may differ from what ground velocity and wind tell
# rad, m, rad/s: a reading that repeats for longer than WINDOW is stuck if the aircraft has
# turned, or climbed, by more than these; a bank, if the turn rate has changed by more than
# STUCK_ROLL. A sensor that is read less often than states are sent repeats itself, too.
STUCK_TURN, STUCK_CLIMB, STUCK_ROLL = 0.04, 3.0, 0.1
# -, factors on the least and the greatest airspeed of the aircraft, beyond which an airspeed is
# impossible (knots taken for m/s read 1.9 times as much), and on the estimated one, between which
# it is used again
POSSIBLE = 0.75, 1.25
# rad: a heading counts from North to East if the aircraft flies for CONTRARY_TIME beside its
# heading by more than this, and beside the mirrored one by less than RETURN of it; and surely so if
# it does while it turns by MIRRORED_TURN: one that errs by a constant does for RETURN of BESIDE
BESIDE, MIRRORED_TURN = 1.0, 1.5
# m, rad: z is positive down once the height has fallen while the nose, of which some are its angle
# of attack, has climbed by more than CLIMBED, far below the target
CLIMBED, NOSE_UP = 20.0, 0.1
# m/s^2: turn rates are in another unit once they would have asked for so much across the path,
# which no airframe bears, for as long as a reading that is stuck stays the same
UNBEARABLE = 60.0


class AirData:
    """The newest airspeed that came by itself, beside the measurements of the aircraft.

    Args:
        timeout: Greatest difference of its stamp from that of a measurement, or of the one before,
            and how long the first one is awaited, in [s].
        found: What the estimate has found of aircraft, air and sensors, by :data:`FOUND`. The path
            is found with an airspeed that fits the wind as it is known without the airspeed:
            heading and path angle, by which the airspeed is judged, must not depend on one that
            fails.

    Attributes:
        missing: Whether the latest vehicle state had no airspeed to go by.
        awaited: Whether it had none because the first airspeed may still come.
        nose: Where it points in [rad] and how it turns in [rad/s], where it is the bank that tells
            how the path does.
        by_turn: Airspeed by bank and turn rate in [m/s]; inf where it is not known.
        bank_lost: Whether a body has told its bank, and it is not gone by now.
        stuck: Whether the heading is stuck, and whether the ground velocity is.
        climb_state: State of a vertical velocity that pitch and height replace.
        limits: Least and greatest airspeed of the aircraft in [m/s].
        holds_altitude: Whether an autopilot does, so that quick changes are not commanded. One
            without a good airspeed does not: it dives, or climbs, by a wrong one.
        impossible: Whether the airspeed is left out because the aircraft cannot fly at it.
        too_fast: Whether airspeed and ground velocity both read more than the greatest airspeed.
            Two sensors say so then, whatever the estimate makes of them.
        far_below: Whether an aircraft that flies the commands seems to be far below its target.
        signs: Of height, climb and heading as they are measured: -1 where z counts down, or the
            heading from North to East.
    """

    def __init__(self, timeout: float, found: SimpleNamespace) -> None:
        self.timeout, self.limits, self.holds_altitude = timeout, (0.0, math.inf), False
        self._found = found
        self.reset()

    def reset(self) -> None:
        """Forget the aircraft and the airspeed."""
        self._stamp, self._airspeed = -math.inf, math.nan
        self.signs, self.far_below = (1.0, 1.0, 1.0), False
        self.begin_anew()

    def begin_anew(self) -> None:
        """Forget the aircraft, as one that is elsewhere; what was measured of the air counts on."""
        self._latest = self._before = -math.inf  # stamps of the two newest measurements
        self.missing = self.awaited = self.impossible = self.too_fast = False
        self._path = FlightPath()
        # Of each reading that must change as the aircraft does: what it is, for how long it has
        # been that [s], how the aircraft has changed meanwhile, whether it is stuck.
        self._repeated: list[tuple[object, float, float, bool]] = [(None, 0.0, 0.0, False)] * 5
        self._turn_rate = 0.0  # rad/s, of the nose
        self._place, self._stays = (math.nan,) * 3, 0.0  # m, and for how long it is the same in [s]
        self.stuck, self.climb_state = (False, False), USED
        self._first = math.inf  # stamp of the first measurement; -inf after an airspeed
        self.nose: tuple[float, float] | None = None
        self._banked = self.bank_lost = False
        self.by_turn, self._mirrored, self._unbearable = math.inf, 0.0, 0.0
        self._course = self._turned = 0.0  # rad, of the velocity, and by which while mirrored
        self._climbs = 0.0, 0.0, 0.0  # m, far below the target: by nose, height and climb

    def see(self, stamp: float, airspeed: float) -> None:
        """Take in a measured airspeed.

        Args:
            stamp: When it was measured in [s].
            airspeed: In [m/s].

        Raises:
            MeasurementError: One of them is not finite, or the airspeed is negative.
        """
        if not (math.isfinite(stamp) and math.isfinite(airspeed) and airspeed >= 0.0):
            raise MeasurementError(
                f"airspeed is {airspeed!r} m/s at {stamp!r} s, must be finite and at least 0 m/s"
            )
        self._stamp, self._airspeed = stamp, airspeed

    def see_state(self, measurement: Measurement) -> tuple[Measurement, NDArray[np.float64]]:
        """The measurement, of the path through the air, and (x, y, z, psi, chi, v), shape (6,).

        Without an airspeed the velocity over ground is taken for that through the air.

        Args:
            measurement: Its own airspeed counts first, then the one that came by itself.
        """
        airspeed, stamp = measurement.airspeed, measurement.stamp
        if min(self.signs) < 0.0:
            height, climb, sense = self.signs
            heading = measurement.heading if sense > 0.0 else 0.5 * math.pi - measurement.heading
            measurement = replace(
                measurement,
                position=measurement.position * [1.0, 1.0, height],
                ground_velocity=measurement.ground_velocity * [1.0, 1.0, climb],
                heading=math.remainder(heading, math.tau),
            )
        height_noise = max(measurement.noise.position[2], float(self._found.position_noise[0]))
        if stamp != self._latest:
            self._compare(measurement, min(stamp - self._latest, self.timeout), height_noise)
            self._before, self._latest = self._latest, stamp
        if self.turn_failed:  # the heading tells how it turns
            measurement = replace(measurement, turn_rate=0.0, path_angle_rate=0.0)
        if airspeed is None and any(
            abs(each - self._stamp) <= self.timeout for each in (stamp, self._before)
        ):
            airspeed = self._airspeed
        east, north, up = measurement.ground_velocity.tolist()
        speed = math.hypot(east, north, up)
        # Airspeed by ground velocity and wind, in [m/s]
        expected = math.dist((east, north, up), self._found.without.tolist())
        self.impossible = self._is_impossible(airspeed, expected, speed)
        self.too_fast = airspeed is not None and min(airspeed, speed) > self.limits[1]
        airspeed = None if self.impossible else airspeed
        self.missing = airspeed is None
        self._first = min(self._first, stamp) if self.missing else -math.inf
        self.awaited = self.missing and stamp - self._first < self.timeout
        held = self.holds_altitude and not (self.missing or self._failed)
        heading_stuck, bank_stuck, velocity_stuck, *climbs_stuck = [
            each[-1] for each in self._repeated
        ]
        climb_stuck = any(climbs_stuck)
        plausible = self._plausible(expected, airspeed)
        attitude = replace(measurement, bank=None) if bank_stuck else measurement
        of_path = self._path.of(
            attitude,
            plausible,
            climb_frequency=SLOW_CLIMB if held else QUICK_CLIMB,
            height_noise=height_noise,
            velocity_failed=self._velocity_failed,
            climb_stuck=climb_stuck,
            heading_failed=bool(self._found.states[1] or self._found.snapped[0]),
            heading_stuck=heading_stuck,
        )
        self.nose, self.by_turn, self.climb_state = None, math.inf, USED
        if of_path is not attitude:
            self.nose = measurement.heading, measurement.turn_rate
            self.by_turn = plausible * self._path.airspeed_share
            self._banked = True
            if climb_stuck or self._path.climb.failed:
                self.climb_state = STUCK if climb_stuck else OFF
        self.bank_lost = self._banked and self.nose is None
        self.stuck = heading_stuck, velocity_stuck or (climb_stuck and self.nose is None)
        vehicle = of_path.state(speed if airspeed is None else airspeed)
        if airspeed is None and speed > SLOW:
            vehicle[3:5] = math.atan2(north, east), math.atan2(up, math.hypot(east, north))
        return of_path, vehicle

    def _is_impossible(self, airspeed: float | None, expected: float, speed: float) -> bool:
        """Whether nobody flies at an airspeed, or it does not agree yet with what stood in."""
        if airspeed is None:
            return False
        (low, high), (least, most) = POSSIBLE, self.limits

        def agrees(other: float) -> bool:
            return low <= airspeed / max(other, SLOW) <= high

        wind_known = self._found.known[0] and not self._velocity_failed
        if wind_known and agrees(expected):  # as after an engine that has failed
            return False
        if airspeed > high * most or (airspeed < low * least < speed):
            return True
        estimated = float(self._found.vehicle[5])
        # What was estimated by it before agrees with it for too long where the wind does not.
        return self.impossible and (wind_known or (estimated > 0.0 and not agrees(estimated)))

    def _compare(self, measurement: Measurement, elapsed: float, height_noise: float) -> None:
        """Whether heading and ground velocity change as the aircraft does."""
        velocity, place = measurement.ground_velocity.tolist(), tuple(measurement.position.tolist())
        turned = elapsed * measurement.turn_rate
        # Only a new position tells a velocity that is stuck from a receiver that is read seldom.
        repeats = place[:2] == self._place[:2] or not measurement.placed
        self._stays = repeats * (self._stays + elapsed)
        waits = STALE if self._stays > STALE else math.inf
        seldom = waits if repeats else WINDOW
        told = measurement.axis is Axis.BODY and measurement.bank is not None
        rolled, self._turn_rate = measurement.turn_rate - self._turn_rate, measurement.turn_rate
        climbed = place[2] - self._place[2] - elapsed * velocity[2]
        # Where height and climb are stuck together, the pitch tells.
        by_pitch = elapsed * self._path.climb.missed
        most = STUCK_CLIMB + NOISE_MULTIPLE * height_noise
        checks = (
            (measurement.heading, turned, STUCK_TURN, WINDOW),
            (measurement.bank, told * rolled, STUCK_ROLL, WINDOW),
            (velocity, turned, STUCK_TURN, seldom),
            (velocity[2], 0.0 if math.isnan(climbed) else climbed, most, seldom),
            (velocity[2], by_pitch, STUCK_CLIMB, seldom),
        )
        for index, (reading, change, limit, longest) in enumerate(checks):
            last, stood, changed, stuck = self._repeated[index]
            same = reading == last
            stood, changed = same * (stood + elapsed), same * (changed + change)
            stuck = same and (stuck or (stood > longest and abs(changed) > limit))
            self._repeated[index] = reading, stood, changed, stuck
        self._see_height(place[2] - self._place[2], elapsed, velocity, measurement.path_angle)
        self._place = place
        # A heading that counts from North to East is the mirrored one.
        course = math.atan2(velocity[1], velocity[0])
        beside = abs(math.remainder(course - measurement.heading, math.tau))
        mirrored = abs(math.remainder(course + measurement.heading - 0.5 * math.pi, math.tau))
        across = abs(measurement.turn_rate) * math.hypot(*velocity[:2])
        if not self.turn_failed:
            self._unbearable = (across > UNBEARABLE) * (self._unbearable + elapsed)
        stuck = self._repeated[0][-1] or self._repeated[2][-1]
        sound = math.hypot(*velocity[:2]) > LEAST_AIRSPEED and not (stuck or self._velocity_failed)
        looks = beside > BESIDE and mirrored < RETURN * BESIDE
        turned, self._course = math.remainder(course - self._course, math.tau), course
        self._mirrored = self._mirrored + elapsed if looks and sound else 0.0
        self._turned = self._turned + turned if self._mirrored > elapsed else 0.0
        if abs(self._turned) > MIRRORED_TURN:
            self.signs = *self.signs[:2], -self.signs[2]

    def _see_height(self, rise: float, elapsed: float, velocity: list[float], pitch: float) -> None:
        """Whether z is positive down: it falls while the aircraft, far below its target, climbs."""
        if not self.far_below or math.isnan(rise):
            self._climbs = 0.0, 0.0, 0.0
        elif pitch > NOSE_UP:
            by_nose = elapsed * math.hypot(*velocity) * math.sin(pitch - NOSE_UP)
            nose, risen, climbed = self._climbs
            nose, risen, climbed = nose + by_nose, risen + rise, climbed + elapsed * velocity[2]
            self._climbs = nose, risen, climbed
            if nose > CLIMBED and risen < -RETURN * nose:
                height, climb, heading = self.signs
                self.signs = -height, math.copysign(climb, climb * climbed), heading

    @property
    def turn_failed(self) -> bool:
        """Whether the rates of turn and path angle are in another unit, and left out."""
        return self._unbearable >= WINDOW

    @property
    def _failed(self) -> bool:
        """Whether the airspeed is known to be wrong."""
        return bool(self._found.states[0] > CODE[SILENT])

    @property
    def _velocity_failed(self) -> bool:
        """Whether the ground velocity is: the path then goes by pitch and height."""
        return bool(self._found.states[3])

    @property
    def surplus(self) -> float:
        """What the aircraft turns quicker than its bank says, in [rad/s]; negative where slower.

        While the bank is left out, what was learnt from it counts for nothing: 0.
        """
        return 0.0 if self.nose is None else self._path.direction.surplus

    def _plausible(self, expected: float, airspeed: float | None) -> float:
        """Airspeed that fits the wind, in [m/s]."""
        if airspeed is None:
            return float(self._found.vehicle[5]) if self._velocity_failed else expected
        if not self._found.known[0] or self._velocity_failed:
            return airspeed
        gusts = 0.0 if self._failed else GUSTS
        return min(max(airspeed, expected - gusts), expected + gusts)

    def concerns(self, wind_known: bool = False) -> dict[str, bool]:
        """What may be taken otherwise than it is measured, in words, and whether it is.

        Args:
            wind_known: Whether the wind stands in for an airspeed that is missing.
        """
        unknown = self.missing and not self.awaited and not wind_known
        return {
            "the heading looks as if it counted from North to East: it must count from East to "
            "North (ENU)": self._mirrored > CONTRARY_TIME,
            "the height falls as the aircraft climbs: z is taken as positive down": (
                self.signs[0] < 0.0
            ),
            "the heading counts from North to East: it is taken so": self.signs[2] < 0.0,
            "the turn rate is more than any airframe bears: it must be in rad/s, and is left out": (
                self.turn_failed
            ),
            "the nose turns against the bank: the attitude is taken for the direction flown": (
                self._path.contradicted
            ),
            "the bank is stuck: the attitude is taken for the direction flown": (
                self._repeated[1][-1]
            ),
            "no airspeed is measured: the air is taken as still": unknown,
        }
