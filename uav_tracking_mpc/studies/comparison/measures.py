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

r"""What counts of a flight, from the true trajectory and the configuration's limits alone.

Nothing here asks the controller. What depends on rates is that of the interval between two samples
of the state, with the mean of position, path angle and airspeed over it; the bank, for instance:

.. math:: \tan\phi = \frac{\bar v}{g} \frac{\Delta\psi}{\Delta t}
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.dynamics.frames import wrap_angle
from uav_tracking_mpc.limits import TOLERANCE, Motion
from uav_tracking_mpc.report.metrics import flown_bank, settling_time
from uav_tracking_mpc.settings.tracking import TrackingParameters
from uav_tracking_mpc.simulation.flight_log import FlightLog

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
        envelope_violations: Of the whole flight: samples at which some limit was passed by more
            than 1 %.
        violations: How many of them for each limit that was passed.
        off_plan: Commands that were neither an optimal plan nor the answer of the law that flew;
            None where that was not recorded.
    """

    range_rms_m: float
    range_mean_m: float
    worst_m: float
    settling_s: float | None
    altitude_rms_m: float
    airspeed_rms_mps: float
    bank_rate_rms_dps: float
    envelope_violations: int
    violations: dict[str, int]
    off_plan: int | None


def measures(
    log: FlightLog, parameters: TrackingParameters, settled_after: float | None = None
) -> Measures:
    """Measure a flight.

    Args:
        log: Record of the flight, at least four samples.
        parameters: The limits.
        settled_after: Time in [s] from which on the flight counts; its last third by default.
    """
    range_error, _, altitude_error, _, airspeed_error = log.error.T
    if settled_after is None:
        settled_after = 2.0 / 3.0 * (log.time[-1] - log.time[0])
    late = log.time >= log.time[0] + settled_after
    bank_rate = np.diff(flown_bank(log)) / np.diff(log.time)[1:]  # at the samples but two
    beyond = violations(log, parameters)
    off_plan = None
    if log.nominal is not None:
        counted = log.command_time >= log.time[0] + settled_after
        off_plan = int(np.count_nonzero(counted & ~log.nominal))
    return Measures(
        range_rms_m=_rms(range_error[late]),
        range_mean_m=float(np.mean(range_error[late])),
        worst_m=float(np.max(np.abs(range_error[late]))),
        settling_s=settling_time(log.time, range_error, SETTLED),
        altitude_rms_m=_rms(altitude_error[late]),
        airspeed_rms_mps=_rms(airspeed_error[late]),
        bank_rate_rms_dps=float(np.degrees(_rms(bank_rate[late[1:-1]]))),
        envelope_violations=int(np.any(list(beyond.values()), axis=0).sum()),
        violations={name: int(found.sum()) for name, found in beyond.items() if found.any()},
        off_plan=off_plan,
    )


def violations(
    log: FlightLog, parameters: TrackingParameters, tolerance: float = TOLERANCE
) -> dict[str, NDArray[np.bool_]]:
    """At which samples which limit is passed by more than a tolerance, each of shape (n,).

    Bank and force are those of the interval after a sample.

    Args:
        log: Record of the flight.
        parameters: The limits.
        tolerance: As a share of the bound [-].

    Returns:
        By the label of the limit.
    """
    at_samples, between = _at_samples(log), _between_samples(log)
    passed = {}
    for limit in parameters.envelope.limits:
        motion, targets = at_samples, log.target
        if limit.of_rates:
            motion, targets = between, log.target[:-1]
        bound = limit.flown(motion, limit.numbers(targets).T)
        if bound is not None:
            # The last sample begins no interval.
            passed[limit.label] = np.append(bound.passed(tolerance), False)[: len(log.time)]
    return passed


def _at_samples(log: FlightLog) -> Motion:
    x, y, z, _, path_angle, airspeed = log.vehicle.T
    x_target, y_target, z_target = log.target.T
    return Motion(x - x_target, y - y_target, z - z_target, path_angle, airspeed)


def _between_samples(log: FlightLog) -> Motion:
    samples, step = _at_samples(log), np.diff(log.time)
    _, _, _, heading, _, _ = log.vehicle.T
    return Motion(
        x=_middle(samples.x),
        y=_middle(samples.y),
        z=_middle(samples.z),
        path_angle=_middle(samples.path_angle),
        airspeed=_middle(samples.airspeed),
        turn_rate=np.asarray(wrap_angle(np.diff(heading))) / step,
        acceleration=np.diff(samples.airspeed) / step,
    )


def _middle(values: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray(0.5 * (values[1:] + values[:-1]))


def _rms(values: NDArray[np.float64]) -> float:
    return float(np.sqrt(np.mean(values**2)))
