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

r"""What counts of a flight.

Measures are from the true trajectory and the configuration's limits alone: nothing here asks the
controller. What depends on rates is that of the interval between two samples of the state, with the
mean of position, path angle and airspeed over it; the bank, for instance:

.. math:: \tan\phi = \frac{\bar v}{g} \frac{\Delta\psi}{\Delta t}

A plant that tells its roll angle is judged by that: its air velocity turns in every gust, its wings
do not.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.dynamics.air import GRAVITY
from uav_tracking_mpc.dynamics.frames import bank_from_turn_rate
from uav_tracking_mpc.limits import TOLERANCE, Motion
from uav_tracking_mpc.limits.turn import Bank
from uav_tracking_mpc.report.metrics import flown_bank, settling_time
from uav_tracking_mpc.settings.tracking import TrackingParameters
from uav_tracking_mpc.simulation.flight_log import FlightLog, SensorNews

# Tolerances where gusts shake the aircraft.
SHAKEN, SHAKEN_BANK = 0.03, math.radians(2.0)  # -, rad: share of a bound, and bank
DEPARTED, STEADY_LATER, STARTS_EARLIER = 1.5, 10.0, 20.0  # m/s, s, s: of the airspeed
SETTLED = 10.0  # m of range error: coarser than in a report, for what every law reaches


@dataclass(frozen=True)
class Measures:
    """A flight in numbers; unless said otherwise those of its last third.

    Attributes:
        range_rms_m: Of r - r_d in [m].
        range_mean_m: Of r - r_d in [m].
        worst_m: Greatest abs(r - r_d) in [m].
        settling_s: Of the whole flight: first time from which on abs(r - r_d) < 10 m in [s]; None
            if never.
        altitude_rms_m: Of z - z_d in [m].
        airspeed_rms_mps: Of v - v_d in [m/s].
        bank_rate_rms_dps: Of the rate of the bank that was flown in [deg/s].
        swing_deg: Greatest difference between the bank that was flown and that of the orbit at the
            same azimuth, in the air and about the target as they are, in [deg].
        softened: Of the whole flight: greatest factor by which a limit cycle made changes of an
            input weigh more [-]; 1 where there was none.
        envelope_violations: Of the whole flight: samples at which some limit was passed by more
            than 1 %; where gusts shake an aircraft whose response is told wrong, by more than 3 %,
            and of the bank by more than 2 deg.
        violations: How many of them for each limit that was passed.
        off_plan: Commands that were neither an optimal plan nor the answer of the law that flew;
            None where that was not recorded.
        altitude_min_m: Least z - z_d in [m].
        altitude_max_m: Greatest z - z_d in [m].
        airspeed_worst_mps: Greatest abs(v - v_d), from 10 s later on than the others, in [m/s].
        airspeed_min_mps: Least airspeed of the whole flight in [m/s].
        airspeed_max_mps: Greatest airspeed of the whole flight in [m/s].
        airspeed_departed_s: Of each flight: first time at which v is more than 1.5 m/s off, from
            20 s earlier on than the others, in [s]; None if never.
        sensors: Of each flight: when the controller left which sensor out or took it back, and why.
    """

    range_rms_m: float
    range_mean_m: float
    worst_m: float
    settling_s: float | None
    altitude_rms_m: float
    airspeed_rms_mps: float
    bank_rate_rms_dps: float
    swing_deg: float
    softened: float
    envelope_violations: int
    violations: dict[str, int]
    off_plan: int | None
    altitude_min_m: float = 0.0
    altitude_max_m: float = 0.0
    airspeed_worst_mps: float = 0.0
    airspeed_min_mps: float = 0.0
    airspeed_max_mps: float = 0.0
    airspeed_departed_s: tuple[float | None, ...] = ()
    sensors: tuple[tuple[SensorNews, ...], ...] = ()


def measures(
    log: FlightLog,
    parameters: TrackingParameters,
    settled_after: float | None = None,
    shaken: bool = False,
) -> Measures:
    """Measure a flight.

    Args:
        log: Record of the flight, at least four samples.
        parameters: The limits.
        settled_after: Time in [s] from which on the flight counts; its last third by default.
        shaken: Whether limits are judged as where gusts shake the aircraft.
    """
    range_error, _, altitude_error, _, airspeed_error = log.error.T
    after = 2.0 / 3.0 * (log.time[-1] - log.time[0]) if settled_after is None else settled_after
    begin = float(log.time[0]) + after
    late = log.time >= begin
    off = (np.abs(airspeed_error) > DEPARTED) & (log.time >= begin - STARTS_EARLIER)
    steady = log.time >= min(begin + STEADY_LATER, float(log.time[-1]))
    bank = flown_bank(log)
    bank_rate = np.diff(bank) / np.diff(log.time)[1:]  # at the samples but two
    swing = bank - _middle(_orbit_bank(log))
    beyond = violations(log, parameters, *((SHAKEN, SHAKEN_BANK) if shaken else (TOLERANCE, 0.0)))
    off_plan = None
    if log.nominal is not None:
        off_plan = int(np.count_nonzero((log.command_time >= begin) & ~log.nominal))
    return Measures(
        range_rms_m=_rms(range_error[late]),
        range_mean_m=float(np.mean(range_error[late])),
        worst_m=float(np.max(np.abs(range_error[late]))),
        settling_s=settling_time(log.time, range_error, SETTLED),
        altitude_rms_m=_rms(altitude_error[late]),
        airspeed_rms_mps=_rms(airspeed_error[late]),
        bank_rate_rms_dps=float(np.degrees(_rms(bank_rate[late[1:-1]]))),
        swing_deg=float(np.degrees(np.max(np.abs(swing[late[:-1]])))),
        softened=log.softened,
        envelope_violations=int(np.any(list(beyond.values()), axis=0).sum()),
        violations={name: int(found.sum()) for name, found in beyond.items() if found.any()},
        off_plan=off_plan,
        altitude_min_m=float(np.min(altitude_error[late])),
        altitude_max_m=float(np.max(altitude_error[late])),
        airspeed_worst_mps=float(np.max(np.abs(airspeed_error[steady]))),
        airspeed_min_mps=float(np.min(log.vehicle[:, 5])),
        airspeed_max_mps=float(np.max(log.vehicle[:, 5])),
        airspeed_departed_s=(float(log.time[np.argmax(off)]) if off.any() else None,),
        sensors=(log.sensors,),
    )


def worst(flights: Sequence[Measures]) -> Measures:
    """Each figure of the flight in which it is worst.

    Args:
        flights: At least one.
    """
    names = [field.name for field in dataclasses.fields(Measures)]
    return Measures(**{name: _worst(name, [getattr(f, name) for f in flights]) for name in names})


def _worst(name: str, values: list[Any]) -> Any:
    if name == "violations":
        limits = dict.fromkeys(limit for value in values for limit in value)
        return {limit: max(value.get(limit, 0) for value in values) for limit in limits}
    if isinstance(values[0], tuple):  # of each flight
        return sum(values, ())
    if None in values:  # never settled, or not recorded
        return None
    return min(values) if "_min_" in name else max(values, key=abs)


def violations(
    log: FlightLog,
    parameters: TrackingParameters,
    tolerance: float = TOLERANCE,
    bank_tolerance: float = 0.0,
) -> dict[str, NDArray[np.bool_]]:
    """At which samples which limit is passed by more than a tolerance, each of shape (n,).

    Bank and force are those of the interval after a sample.

    Args:
        log: Record of the flight.
        parameters: The limits.
        tolerance: As a share of the bound [-].
        bank_tolerance: Of the bank in [rad], where that is more; of a measured bank it is at least
            :data:`SHAKEN_BANK`.

    Returns:
        By the label of the limit.
    """
    at_samples, between = _at_samples(log), _between_samples(log)
    if log.measured_bank is not None:
        bank_tolerance = max(bank_tolerance, SHAKEN_BANK)
    passed = {}
    for limit in parameters.envelope.limits:
        motion = between if limit.of_rates else at_samples
        bound = limit.flown(motion, limit.numbers(log.target[: len(motion.x)]).T)
        if bound is not None:
            allowed = tolerance
            if isinstance(limit, Bank):
                allowed = max(tolerance, bank_tolerance / limit.bank_max)
            # The last sample begins no interval.
            passed[limit.label] = np.append(bound.passed(allowed), False)[: len(log.time)]
    return passed


def _at_samples(log: FlightLog) -> Motion:
    x, y, z, _, path_angle, airspeed = log.vehicle.T
    x_target, y_target, z_target = log.target.T
    return Motion(x - x_target, y - y_target, z - z_target, path_angle, airspeed)


def _between_samples(log: FlightLog) -> Motion:
    samples, step = _at_samples(log), np.diff(log.time)
    return Motion(
        x=_middle(samples.x),
        y=_middle(samples.y),
        z=_middle(samples.z),
        path_angle=_middle(samples.path_angle),
        airspeed=_middle(samples.airspeed),
        turn_rate=-GRAVITY * np.tan(flown_bank(log)) / _middle(samples.airspeed),
        acceleration=np.diff(samples.airspeed) / step,
    )


def _orbit_bank(log: FlightLog) -> NDArray[np.float64]:
    """Bank of steady flight on the orbit at the azimuths of the samples, shape (n,), in [rad].

    psi' = sigma s^2 / (d q), as of :func:`~uav_tracking_mpc.dynamics.orbit.orbit_motion`.
    """
    x, y = (log.vehicle[:, :2] - log.target[:, :2]).T
    sense, distance, airspeed = log.orbit.sense, np.hypot(x, y), log.vehicle[:, 5]
    t_x, t_y = -sense * y / distance, sense * x / distance
    c_x, c_y, _ = log.drift.T
    q = np.sqrt(np.maximum(airspeed**2 - (c_y * t_x - c_x * t_y) ** 2, 1e-3 * airspeed**2))
    s = c_x * t_x + c_y * t_y + q
    return np.asarray(bank_from_turn_rate(sense * s**2 / (log.radius * q), airspeed))


def _middle(values: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray(0.5 * (values[1:] + values[:-1]))


def _rms(values: NDArray[np.float64]) -> float:
    return float(np.sqrt(np.mean(values**2)))
