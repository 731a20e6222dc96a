r"""What counts of a flight, from the true trajectory and the configuration's limits alone.

Nothing here asks the controller or its model of the envelope: bank and specific force are those
flown between two samples of the state,

.. math::

    \tan\phi = \frac{\bar v}{g} \frac{\Delta\psi}{\Delta t}, \qquad
    f = g \sin\bar\chi + \frac{\Delta v}{\Delta t}

with the mean of path angle and airspeed over the interval.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.dynamics.angles import wrap_angle
from uav_tracking_mpc.dynamics.gravity import GRAVITY
from uav_tracking_mpc.report.metrics import settling_time
from uav_tracking_mpc.settings.tracking import TrackingParameters
from uav_tracking_mpc.simulation.flight_log import FlightLog

SETTLED = 10.0  # m of range error below which a flight counts as settled
TOLERANCE = 0.01  # share of a limit by which it may be passed


@dataclass(frozen=True)
class Measures:
    """A flight in numbers; RMS values are those of the last third.

    Attributes:
        range_rms_m: Of r - r_d in [m].
        settling_s: First time from which on abs(r - r_d) < 10 m in [s]; None if never.
        altitude_rms_m: Of z - z_d in [m].
        airspeed_rms_mps: Of v - v_d in [m/s].
        bank_rate_rms_dps: Of the rate of the bank that was flown in [deg/s].
        envelope_violations: Samples at which some limit was passed by more than 1 %.
        violations: How many of them for each limit that was passed.
    """

    range_rms_m: float
    settling_s: float | None
    altitude_rms_m: float
    airspeed_rms_mps: float
    bank_rate_rms_dps: float
    envelope_violations: int
    violations: dict[str, int]


def measures(log: FlightLog, parameters: TrackingParameters) -> Measures:
    """Measure a flight.

    Args:
        log: Record of the flight, at least four samples.
        parameters: The limits.
    """
    error = log.error
    late = log.time >= log.time[0] + 2.0 / 3.0 * (log.time[-1] - log.time[0])
    bank_rate = np.diff(flown_bank(log)) / np.diff(log.time)[1:]  # at the samples but two
    beyond = violations(log, parameters)
    return Measures(
        range_rms_m=_rms(error[late, 0]),
        settling_s=settling_time(log.time, error[:, 0], SETTLED),
        altitude_rms_m=_rms(error[late, 2]),
        airspeed_rms_mps=_rms(error[late, 4]),
        bank_rate_rms_dps=float(np.degrees(_rms(bank_rate[late[1:-1]]))),
        envelope_violations=int(np.any(list(beyond.values()), axis=0).sum()),
        violations={name: int(found.sum()) for name, found in beyond.items() if found.any()},
    )


def flown_bank(log: FlightLog) -> NDArray[np.float64]:
    """Bank of a coordinated turn between each two samples, shape (n - 1,), in [rad].

    Positive to the left, as the turn rate that it comes from.

    Args:
        log: Record of the flight.
    """
    turn = np.asarray(wrap_angle(np.diff(log.vehicle[:, 3]))) / np.diff(log.time)
    return np.arctan(_middle(log.vehicle[:, 5]) * turn / GRAVITY)


def flown_force(log: FlightLog) -> NDArray[np.float64]:
    """Thrust less drag over mass between each two samples, shape (n - 1,), in [m/s^2].

    Args:
        log: Record of the flight.
    """
    climb = GRAVITY * np.sin(_middle(log.vehicle[:, 4]))
    return np.asarray(climb + np.diff(log.vehicle[:, 5]) / np.diff(log.time))


def violations(log: FlightLog, parameters: TrackingParameters) -> dict[str, NDArray[np.bool_]]:
    """At which samples which limit is passed by more than :data:`TOLERANCE`, each of shape (n,).

    Bank and force are those of the interval after a sample.

    Args:
        log: Record of the flight.
        parameters: The limits.
    """
    p = parameters
    z, chi, v = log.vehicle[:, 2], log.vehicle[:, 4], log.vehicle[:, 5]
    speeds, middle = (p.airspeed_min, p.airspeed_max), _middle(v)
    bank, force = np.abs(flown_bank(log)), flown_force(log)
    beyond = {
        "airspeed": _below(v, p.airspeed_min) | _above(v, p.airspeed_max),
        "path angle": _below(chi, p.path_angle_min) | _above(chi, p.path_angle_max),
        "bank": _above(bank, p.bank_max),
        "force": _below(force, np.interp(middle, speeds, p.force_min))
        | _above(force, np.interp(middle, speeds, p.force_max)),
        "height": _below(z, p.height_min),
        "distance": _below(np.linalg.norm(log.vehicle[:, :3] - log.target, axis=1), p.distance_min),
    }
    if p.fence_radius > 0.0:
        away = np.hypot(*(log.vehicle[:, :2] - p.fence_centre).T)
        beyond["fence"] = _above(away, p.fence_radius)
    # The last sample begins no interval.
    return {name: np.append(found, False)[: len(v)] for name, found in beyond.items()}


def _above(values: NDArray[np.float64], limit: float | NDArray[np.float64]) -> NDArray[np.bool_]:
    return np.asarray(~(values <= limit + TOLERANCE * np.abs(limit) + 1e-9))


def _below(values: NDArray[np.float64], limit: float | NDArray[np.float64]) -> NDArray[np.bool_]:
    return np.asarray(~(values >= limit - TOLERANCE * np.abs(limit) - 1e-9))


def _middle(values: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray(0.5 * (values[1:] + values[:-1]))


def _rms(values: NDArray[np.float64]) -> float:
    return float(np.sqrt(np.mean(values**2)))
