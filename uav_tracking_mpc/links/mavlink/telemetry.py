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

"""What an autopilot tells in flight, put together to measurements by our clock.

==========================  ==========================================================
GLOBAL_POSITION_INT         position, ground velocity, path angle: each makes a measurement
ATTITUDE                    heading and its rate; carried on to the position's time
VFR_HUD                     airspeed, which both autopilots tell as calibrated
WIND, WIND_COV              the autopilot's estimate of the wind, ArduPilot's and PX4's
HOME_POSITION               origin of ``map`` unless another is stated
ESTIMATOR_STATUS, GPS raw   accuracies: see :class:`Accuracies`
==========================  ==========================================================

Position comes from latitude and longitude, see :mod:`~uav_tracking_mpc.dynamics.geodesy`. The path
angle is that of the flight through the air, w = v sin(chi), behind a filter, and not the nose's
elevation, which an angle of attack lies above it.

ESTIMATOR_STATUS is PX4's filter: standard deviations of the position, horizontal and vertical.
GPS_RAW_INT has the receiver's of position and velocity, where that of the filter is missing.
ArduPilot's EKF_STATUS_REPORT tells no variances, for all the names of its fields: they are
innovations as a share of their gates. Neither autopilot tells how accurate heading and airspeed
are.
"""

from __future__ import annotations

import contextlib
import math
from collections import deque
from statistics import pstdev
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.dynamics.air import true_over_equivalent
from uav_tracking_mpc.dynamics.frames import course_rates_from_euler, heading_from_yaw
from uav_tracking_mpc.dynamics.geodesy import LocalFrame
from uav_tracking_mpc.estimation.flight_path import LEAST_AIRSPEED
from uav_tracking_mpc.estimation.measurement import SILENT, Measurement, SensorNoise, told_noise
from uav_tracking_mpc.links.mavlink.dialect import mavlink

KEPT = 20  # round trips
LONGEST = 1.0  # s of a round trip that tells anything
AHEAD = 1.0  # s by which a stamp may lie in the future before its clock is doubted
BACK = 1.0  # s by which a stamp may lie before the newest one before its clock is doubted
WITNESSES = 3  # stamps or answers that must doubt the clock alike: one may be an old repeat
DOUBTED_FOR = 0.1  # s of stamps that must: on a wire that repeats old frames several come in a row


class RoundTrip(NamedTuple):
    """One exchange.

    Attributes:
        offset: Autopilot's time minus ours in [s].
        duration: Of the round trip in [s].
    """

    offset: float
    duration: float

    def agrees(self, other: RoundTrip) -> bool:
        """Whether one offset lies within half the round trip of both."""
        return abs(self.offset - other.offset) <= 0.5 * (self.duration + other.duration)


class AutopilotClock:
    r"""Offset of the autopilot's time since its boot to our clock, from round trips of TIMESYNC.

    We send our time :math:`t_1`, the autopilot answers with its own :math:`t_a`, the answer arrives
    at :math:`t_2` (MAVLink guide, Timesync). Its clock is then ours plus
    :math:`t_a - (t_1 + t_2)/2`, wrong by at most half the round trip. The quickest of the last
    round trips counts: queues only ever add to them (Mills, RFC 5905, Section 10). One that the
    newest contradicts is forgotten: a simulation in lockstep may run a hundredth slower than our
    clock, and an offset that is ten seconds old would be a tenth of a second wrong. Until the first
    answer the least delay of telemetry counts: the stamp of a message is at most now.

    Attributes:
        offset: Autopilot's time minus ours in [s]; None while nothing is known.
        jitter: Standard deviation of the round trips' offsets in [s]; 0 while there are too few.
        delay: Half of the quickest round trip in [s]; 0 while there is none.
        restarts: How often the clock was started anew.
    """

    def __init__(self) -> None:
        self.restarts = 0
        self.forget()

    def forget(self) -> None:
        """Begin anew: the autopilot has restarted."""
        self._trips: deque[RoundTrip] = deque(maxlen=KEPT)
        self._doubts: list[float] = []
        self._strays: list[RoundTrip] = []
        self._newest = -math.inf
        self.offset: float | None = None
        self.jitter = self.delay = 0.0

    def see_stamp(self, stamp: float, arrival: float) -> bool:
        """Take in the stamp of telemetry.

        Args:
            stamp: Autopilot's time since its boot in [s].
            arrival: Our time in [s].

        Returns:
            Whether it is of this boot, as far as is known: of another one nothing is to be used.
        """
        if not (math.isfinite(stamp) and math.isfinite(arrival)):
            return False
        seen = stamp - arrival
        # However late telemetry is, its stamps go on; those of another boot begin anew.
        ahead = self.offset is not None and seen - self.offset > AHEAD
        if ahead or stamp < self._newest - BACK:
            alike = [other for other in self._doubts if abs(other - stamp) <= AHEAD]
            self._doubts = [*alike, stamp]
            lasted = max(self._doubts) - min(self._doubts)
            if len(self._doubts) < WITNESSES or lasted < DOUBTED_FOR:
                return False
            self.restarts += 1
            self.forget()
        self._doubts, self._newest = [], max(self._newest, stamp)
        if not self._trips:
            self.offset = seen if self.offset is None else max(self.offset, seen)
        return True

    def see_answer(self, sent: float, answered: float, arrival: float) -> None:
        """Take in an answer to a round trip.

        Args:
            sent: Our time when it was asked in [s].
            answered: Autopilot's time when it answered in [s].
            arrival: Our time when the answer came in [s].
        """
        duration = arrival - sent
        if not (0.0 <= duration <= LONGEST and math.isfinite(answered)):
            return
        trip = RoundTrip(answered - 0.5 * (sent + arrival), duration)
        if self._trips and abs(trip.offset - self._trips[-1].offset) > AHEAD:
            # Of another boot, or the clock stood still: those that agree count from now on.
            alike = [other for other in self._strays if abs(other.offset - trip.offset) <= AHEAD]
            self._strays = [*alike, trip]
            if len(self._strays) < WITNESSES:
                return
            self._trips.clear()
            self._trips.extend(self._strays)
        else:
            self._trips.append(trip)
        self._strays = []
        kept = [each for each in self._trips if each.agrees(trip)]
        if len(kept) < len(self._trips):
            self._trips = deque(kept, maxlen=KEPT)
        best, reach = min(self._trips, key=lambda each: each.duration), 0.5 * duration
        self.offset = min(max(best.offset, trip.offset - reach), trip.offset + reach)
        self.delay = 0.5 * best.duration
        self.jitter = pstdev(each.offset for each in self._trips)

    def ours(self, stamp: float) -> float:
        """Our time of a stamp of the autopilot in [s].

        Args:
            stamp: Autopilot's time since its boot in [s].

        Raises:
            ValueError: Nothing is known of its clock.
        """
        if self.offset is None:
            raise ValueError("nothing is known of the autopilot's clock")
        return stamp - self.offset


AGE = 5.0  # s that what is told counts
MILLI = 1e-3  # m or m/s, code: unit on the wire


class Accuracies:
    """The newest that were told."""

    def __init__(self) -> None:
        self._told: dict[str, tuple[tuple[float, ...], float]] = {}  # and when, in s

    def see(self, message: Any, arrival: float) -> None:
        """Take in a message.

        Args:
            message: Of the autopilot.
            arrival: Our time in [s].
        """
        if message.get_type() == "ESTIMATOR_STATUS":
            axes = _axes("position", message.pos_horiz_accuracy, message.pos_vert_accuracy)
            self._told["filter"] = axes, arrival
        elif message.get_type() == "GPS_RAW_INT":
            speed = MILLI * message.vel_acc
            axes = _axes("position", MILLI * message.h_acc, MILLI * message.v_acc)
            self._told["receiver"] = axes, arrival
            self._told["velocity"] = _axes("velocity", speed, speed), arrival

    def noise(self, now: float) -> SensorNoise:
        """What is told of the noise, in words that are not too old.

        Args:
            now: Our time in [s].
        """
        fresh = {
            name: axes for name, (axes, at) in self._told.items() if now - at <= AGE and any(axes)
        }
        position = fresh.get("filter", fresh.get("receiver", SILENT.position))
        return SensorNoise(position, fresh.get("velocity", SILENT.velocity)) if fresh else SILENT


def _axes(name: str, level: float, vertical: float) -> tuple[float, ...]:
    """Of standard deviations, of which one may be negative or not finite; zeros for unknown."""
    variances = [math.copysign(1.0, value) * value * value for value in (level, level, vertical)]
    return told_noise(name, variances)


DEGREE_SCALE = math.radians(1e-7)  # rad, code: unit of latitude and longitude on the wire
ATTITUDE_AGE = 0.25  # s that attitude and position may lie apart
AIRSPEED_AGE = 1.0  # s that airspeed may be older than the position
STEEPEST = 0.5 * math.pi  # rad, of the pitch
# m from the origin; beyond it the autopilot's filter has no origin yet, or ours is another's home
FARTHEST = 1e6
WIND_AGE = 10.0  # s that a wind counts
AIRSPEED_SENSOR = mavlink.MAV_SYS_STATUS_SENSOR_DIFFERENTIAL_PRESSURE


class Attitude(NamedTuple):
    """Attitude as the autopilot tells it: Forward-Right-Down in North-East-Down.

    Attributes:
        time: Autopilot's time in [s].
        roll: Right wing down in [rad].
        pitch: Nose up in [rad].
        yaw: Clockwise from North in [rad].
        rates: (p, q, r), shape (3,), in [rad/s].
    """

    time: float
    roll: float
    pitch: float
    yaw: float
    rates: tuple[float, float, float]


class Telemetry:
    """Gathers messages of one autopilot.

    Args:
        clock: Of this autopilot.
        origin: Of ``map``; None for the autopilot's home.

    Attributes:
        frame: Axes of ``map``; None until the origin is known.
        attitude: The newest.
        altitude: Above sea level in [m]; None until it is known.
        airspeed: True airspeed in [m/s]; that of ground velocity and wind while the autopilot does
            not use its sensor, whose values it goes on to tell; None where it is unknown or old.
        wind: Velocity of the air in ``map`` by the autopilot, shape (3,), in [m/s]; None where it
            tells nothing.
        throttle: From 0 to 1 [-]; None until it is known.
        surplus: What the aircraft turns quicker than its bank says, by the controller, in [rad/s].
        newest: The newest measurement.
        distance: Of the newest position from the origin of ``map`` in [m]; 0 before the first.
            Beyond :data:`FARTHEST` none is measured.
    """

    def __init__(self, clock: AutopilotClock, origin: LocalFrame | None = None) -> None:
        self._clock = clock
        self.frame = origin
        self.home: LocalFrame | None = None
        self.forget()

    def forget(self) -> None:
        """Forget what belongs to a boot that is over; the origin stays."""
        self.attitude: Attitude | None = None
        self.altitude: float | None = None
        self.wind: NDArray[np.float64] | None = None
        self.newest: Measurement | None = None
        self.distance = 0.0
        self._estimated, self._estimated_at, self.surplus = 0.0, -math.inf, 0.0
        self._accuracies = Accuracies()
        self.throttle: float | None = None
        self._calibrated: float | None = None
        self._distrusted = False  # the airspeed sensor, by the autopilot
        self._calibrated_at = self._wind_at = self._position_at = -math.inf

    @property
    def airspeed(self) -> float | None:
        """See the class."""
        if self._distrusted:
            if self.newest is None or self.wind is None:
                return None
            return float(np.linalg.norm(self.newest.ground_velocity - self.wind))
        if self._calibrated is None or self.altitude is None:
            return None
        return self._calibrated * true_over_equivalent(self.altitude)

    @property
    def flown_airspeed(self) -> float | None:
        """Airspeed that the aircraft flies at in [m/s]; None where it is unknown.

        It is that of the controller, which finds out whether the sensor is wrong: with one that is
        stuck at 5 m/s a bank hardly turns an aircraft that flies at 22. Without a controller that
        tells one it is measured.
        """
        told = self._estimated >= LEAST_AIRSPEED
        airspeed = self._estimated if told else self.airspeed
        return None if airspeed is None or airspeed < LEAST_AIRSPEED else airspeed

    def see_estimate(self, airspeed: float, surplus: float, arrival: float) -> None:
        """Take in what the controller estimates.

        Args:
            airspeed: In [m/s]; 0 where it tells none.
            surplus: What the aircraft turns quicker than its bank says in [rad/s].
            arrival: Our time in [s].
        """
        self._estimated, self._estimated_at, self.surplus = airspeed, arrival, surplus

    def see(self, message: Any, arrival: float) -> Measurement | None:
        """Take in a message.

        Args:
            message: Of the autopilot.
            arrival: Our time in [s].

        Returns:
            A measurement, where the message completes one.
        """
        self._accuracies.see(message, arrival)
        taker = _TAKERS.get(message.get_type())
        return None if taker is None else taker(self, message, arrival)

    def _see_attitude(self, message: Any, arrival: float) -> None:
        rates = (message.rollspeed, message.pitchspeed, message.yawspeed)
        values = (message.roll, message.pitch, message.yaw, *rates)
        time = message.time_boot_ms * 1e-3
        newest = -math.inf if self.attitude is None else self.attitude.time
        if time >= newest and all(map(math.isfinite, values)) and abs(message.pitch) < STEEPEST:
            self.attitude = Attitude(time, message.roll, message.pitch, message.yaw, rates)

    def _see_airspeed(self, message: Any, arrival: float) -> None:
        self.throttle = min(message.throttle * 1e-2, 1.0)
        if math.isfinite(message.airspeed):
            self._calibrated, self._calibrated_at = message.airspeed, arrival

    def _see_sensors(self, message: Any, arrival: float) -> None:
        used = message.onboard_control_sensors_enabled & message.onboard_control_sensors_health
        present = message.onboard_control_sensors_present & AIRSPEED_SENSOR
        self._distrusted = bool(present and not used & AIRSPEED_SENSOR)

    def _see_wind(self, message: Any, arrival: float) -> None:
        # ArduPilot tells where the wind comes from, clockwise from North, and its part down.
        if not math.isfinite(message.direction):
            return
        azimuth = math.radians(message.direction)
        level = math.sqrt(max(message.speed**2 - message.speed_z**2, 0.0))  # of its length in space
        north, east = -level * math.cos(azimuth), -level * math.sin(azimuth)
        self._set_wind([east, north, -message.speed_z], arrival)

    def _see_wind_covariance(self, message: Any, arrival: float) -> None:
        self._set_wind([message.wind_y, message.wind_x, -message.wind_z], arrival)

    def _set_wind(self, wind: list[float], arrival: float) -> None:
        if all(map(math.isfinite, wind)):
            self.wind, self._wind_at = np.array(wind), arrival

    def _see_home(self, message: Any, arrival: float) -> None:
        latitude, longitude = message.latitude * DEGREE_SCALE, message.longitude * DEGREE_SCALE
        with contextlib.suppress(ValueError):  # there is no such latitude
            self.home = LocalFrame(latitude, longitude, message.altitude * 1e-3)
            self.frame = self.frame or self.home

    def _see_position(self, message: Any, arrival: float) -> Measurement | None:
        time = message.time_boot_ms * 1e-3
        if arrival - self._calibrated_at > AIRSPEED_AGE:
            self._calibrated = None
        if arrival - self._wind_at > WIND_AGE:
            self.wind = None
        if arrival - self._estimated_at > AIRSPEED_AGE:
            self._estimated = self.surplus = 0.0
        self.altitude = message.alt * 1e-3
        attitude, newest = self.attitude, self.newest
        if self.frame is None or attitude is None or self._clock.offset is None:
            return None
        stamp = self._clock.ours(time)
        if newest is not None and time <= self._position_at:
            return None  # doubled, or overtaken by a later one
        apart = time - attitude.time
        if abs(apart) > ATTITUDE_AGE or message.lat == message.lon == 0:
            return None
        place = self.frame.position(
            message.lat * DEGREE_SCALE, message.lon * DEGREE_SCALE, self.altitude
        )
        self.distance = float(np.linalg.norm(place))
        if not self.distance <= FARTHEST:
            return None
        turn_rate, elevation_rate = course_rates_from_euler(
            attitude.roll, attitude.pitch, attitude.rates
        )
        nose, airspeed = heading_from_yaw(attitude.yaw) + turn_rate * apart, self.airspeed
        self._position_at = time
        self.newest = Measurement(
            stamp=stamp,
            position=place,
            ground_velocity=1e-2 * np.array([message.vy, message.vx, -message.vz]),
            heading=math.remainder(nose, 2.0 * math.pi),
            path_angle=attitude.pitch,
            turn_rate=turn_rate,
            path_angle_rate=elevation_rate,
            airspeed=None if airspeed is None or airspeed < LEAST_AIRSPEED else airspeed,
            noise=self._accuracies.noise(arrival),
            bank=attitude.roll,
        )
        return self.newest


_TAKERS: dict[str, Any] = {
    "GLOBAL_POSITION_INT": Telemetry._see_position,
    "ATTITUDE": Telemetry._see_attitude,
    "SYS_STATUS": Telemetry._see_sensors,
    "VFR_HUD": Telemetry._see_airspeed,
    "WIND": Telemetry._see_wind,
    "WIND_COV": Telemetry._see_wind_covariance,
    "HOME_POSITION": Telemetry._see_home,
}
