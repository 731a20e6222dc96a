"""Motion of the UAV relative to its target: state (r, theta, z, chi, v), Section 3 of the paper.

theta = psi - phi - pi with phi = atan2(y, x), the azimuth of the UAV seen from the target; the
inputs are (u_psi, u_chi, u_v). Each model's equations stand here once, as CasADi expressions, and
every derivative that the package uses is made from them by machine.

========= ==========================================================================================
``exact``  the kinematics (3) in these coordinates, no approximation
``paper``  (11) as printed: (9) with r^2 - z_p^2 replaced by r^2 cos^2(chi)
``paper9`` (9) as printed
========= ==========================================================================================

(6), (7) and hence (9) replace d/r by cos(chi) and z/r by sin(chi), d = sqrt(r^2 - z^2): true only
when the path angle equals the target's elevation. Their steady turns differ from the true one, so
a controller that predicts with them holds a constant range offset on the true vehicle.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike, NDArray

from uav_tracking_mpc.dynamics.angles import wrap_angle
from uav_tracking_mpc.dynamics.orbit import Orbit
from uav_tracking_mpc.dynamics.vehicle import INPUT_NAMES, air_velocity


class RelativeState(NamedTuple):
    """State (r, theta, z, chi, v) by name; an array of shape (5,) in this order is the same.

    Attributes:
        range: r, distance to the target [m].
        bearing: theta = psi - phi - pi, wrapped to (-pi, pi] [rad].
        altitude: z, height above the target [m].
        path_angle: chi, positive when climbing [rad].
        speed: v [m/s].
    """

    range: float
    bearing: float
    altitude: float
    path_angle: float
    speed: float


STATE_NAMES = RelativeState._fields
NX, NU = len(STATE_NAMES), len(INPUT_NAMES)
_BEARING = STATE_NAMES.index("bearing")

Rates = Callable[[ca.SX, ca.SX], ca.SX]


def exact_rates(state: ca.SX, inputs: ca.SX) -> ca.SX:
    """Time derivative of the relative state, exact: the velocity (3a)-(3c) seen from the target.

    Args:
        state: (r, theta, z, chi, v), shape (5, 1).
        inputs: (u_psi, u_chi, u_v), shape (3, 1).
    """
    r, theta, z, chi, v = ca.vertsplit(state)
    u_psi, u_chi, u_v = ca.vertsplit(inputs)
    d = ca.sqrt(r**2 - z**2)
    # theta is the heading counted from the direction that points at the target.
    inward, across, climb = air_velocity(theta, chi, v, ca)
    return ca.vertcat((climb * z - inward * d) / r, across / d + u_psi, climb, u_chi, u_v)


def paper_rates(state: ca.SX, inputs: ca.SX) -> ca.SX:
    """Rates behind (11) as printed; written for any bearing, (11) is at theta = pi/2 + x_2.

    Args:
        state: (r, theta, z, chi, v), shape (5, 1).
        inputs: (u_psi, u_chi, u_v), shape (3, 1).
    """
    r, theta, _, chi, v = ca.vertsplit(state)
    u_psi, u_chi, u_v = ca.vertsplit(inputs)
    return ca.vertcat(
        v * (ca.sin(chi) ** 2 - ca.cos(theta) * ca.cos(chi) ** 2),  # (9a), (11a)
        v * ca.cos(chi) ** 2 * ca.sin(theta) / (r * (1.0 - ca.sin(chi) ** 2)) + u_psi,  # (11b)
        v * ca.sin(chi),  # (9c), (11c)
        u_chi,  # (9d), (11d)
        u_v,  # (9e), (11e)
    )


def paper9_rates(state: ca.SX, inputs: ca.SX) -> ca.SX:
    """Rates (9) as printed: those of :func:`paper_rates` but for the bearing.

    Args:
        state: (r, theta, z, chi, v), shape (5, 1).
        inputs: (u_psi, u_chi, u_v), shape (3, 1).
    """
    r, theta, z, chi, v = ca.vertsplit(state)
    rates = paper_rates(state, inputs)
    bearing_rate = v * r * ca.cos(chi) ** 2 * ca.sin(theta) / (r**2 - z**2) + inputs[0]  # (9b)
    return ca.vertcat(rates[0], bearing_rate, rates[2:])


MODELS: dict[str, Rates] = {"exact": exact_rates, "paper": paper_rates, "paper9": paper9_rates}


def rates_function(model: str) -> ca.Function:
    """CasADi function (state (5,), inputs (3,)) -> rates (5,) of a model.

    Args:
        model: Name in :data:`MODELS`.

    Raises:
        ValueError: No model of that name.
    """
    if model not in MODELS:
        raise ValueError(f"model is {model!r}, must be one of {', '.join(MODELS)}")
    state, inputs = ca.SX.sym("x", NX), ca.SX.sym("u", NU)
    return ca.Function(f"{model}_rates", [state, inputs], [MODELS[model](state, inputs)])


def steady_inputs(model: str, orbit: Orbit) -> NDArray[np.float64]:
    """u_ss, shape (3,), that holds the orbit in the given model [rad/s, rad/s, m/s^2].

    The turn rate cancels the model's own drift in bearing: every model has theta' = ... + u_psi.

    Args:
        model: Name in :data:`MODELS`.
        orbit: The orbit to hold.
    """
    drift = RelativeState(*rates_function(model)(orbit.steady_state, np.zeros(NU)).full().ravel())
    return np.array([-drift.bearing, 0.0, 0.0])


def relative_state(vehicle: ArrayLike, target: ArrayLike) -> NDArray[np.float64]:
    """Relative state (r, theta, z, chi, v) of a vehicle, (4) and (5).

    Args:
        vehicle: (x, y, z, psi, chi, v), shape (6,).
        target: Position in ``map``, shape (3,), in [m].

    Returns:
        Shape (5,), bearing wrapped to (-pi, pi]. Straight above the target, where phi has no
        value, phi is taken as 0.
    """
    *position, psi, chi, v = np.asarray(vehicle, dtype=float)
    x, y, z = position - np.asarray(target, dtype=float)
    theta = wrap_angle(psi - np.arctan2(y, x) - np.pi)
    return np.array([np.sqrt(x * x + y * y + z * z), theta, z, chi, v])


def vehicle_state(relative: ArrayLike, azimuth: float, target: ArrayLike) -> NDArray[np.float64]:
    """Vehicle state with the given relative state: the inverse of :func:`relative_state`.

    Args:
        relative: (r, theta, z, chi, v), shape (5,), with r >= abs(z).
        azimuth: phi, direction from target to vehicle in [rad]; the relative state leaves it free.
        target: Position in ``map``, shape (3,), in [m].

    Returns:
        (x, y, z, psi, chi, v), shape (6,).

    Raises:
        ValueError: r < abs(z): no such point.
    """
    r, theta, z, chi, v = (float(value) for value in np.asarray(relative))
    if r < abs(z):
        raise ValueError(f"range is {r} m, must be at least |altitude| = {abs(z)} m")
    d = np.sqrt(r * r - z * z)
    offset = np.array([d * np.cos(azimuth), d * np.sin(azimuth), z])
    position = np.asarray(target, dtype=float) + offset
    return np.array([*position, wrap_angle(theta + azimuth + np.pi), chi, v])


def tracking_error(relative: ArrayLike, orbit: Orbit) -> NDArray[np.float64]:
    """Tracking error xbar - x_ss (Section 3.1), with the bearing error wrapped to (-pi, pi].

    Args:
        relative: (r, theta, z, chi, v), shape (5,) or (n, 5).
        orbit: Reference.

    Returns:
        The same shape as ``relative``.
    """
    error = np.asarray(relative, dtype=float) - orbit.steady_state
    error[..., _BEARING] = wrap_angle(error[..., _BEARING])
    return error
