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

"""Motion of the UAV relative to its target, Section 3: coordinates, steady orbits, error form (11).

The models themselves stand in :mod:`uav_tracking_mpc.dynamics.relative_models`.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike, NDArray

from uav_tracking_mpc.dynamics.frames import wrap_angle
from uav_tracking_mpc.dynamics.orbit import Orbit
from uav_tracking_mpc.dynamics.relative_models import RELATIVE_MODEL, RelativeState
from uav_tracking_mpc.dynamics.vehicle import INPUT_NAMES
from uav_tracking_mpc.symbolic.functions import SCHEMES, evaluate, one_at_a_time

STATE_NAMES = RelativeState._fields
NX, NU = len(STATE_NAMES), len(INPUT_NAMES)
_BEARING = STATE_NAMES.index("bearing")
STEADY = 1e-6  # m/s, rad/s, m/s^2: tolerance of the rates on the orbit


def rates_function(model: str) -> ca.Function:
    """CasADi function (state (5,), inputs (3,)) -> rates (5,) of a model.

    Args:
        model: Name of a relative model.

    Raises:
        ExtensionError: No model of that name.
    """
    state, inputs = ca.SX.sym("x", NX), ca.SX.sym("u", NU)
    components = RelativeState._make(ca.vertsplit(state))
    rates = RELATIVE_MODEL.find(model)().rates(components, ca.vertsplit(inputs))
    return ca.Function("rates", [state, inputs], [ca.vertcat(*rates)])


# Once for each model: parameters ask for it in flight, while other threads build expressions.
_kept_rates = lru_cache(one_at_a_time(rates_function))


def steady_inputs(model: str, orbit: Orbit) -> NDArray[np.float64]:
    """u_ss, shape (3,), that holds the orbit in the given model [rad/s, rad/s, m/s^2].

    The turn rate cancels the model's own drift in bearing: every model has theta' = ... + u_psi.

    Args:
        model: Name of a relative model.
        orbit: The orbit to hold.

    Raises:
        ValueError: With these inputs the state does not stay on the orbit.
    """
    rates = _kept_rates(model)
    drift = RelativeState(*rates(orbit.steady_state, np.zeros(NU)).full().ravel())
    steady = np.array([-drift.bearing, 0.0, 0.0])
    left = rates(orbit.steady_state, steady).full().ravel()
    if not np.abs(left).max() < STEADY:
        raise ValueError(
            f"a turn rate of {steady[0]:.6g} rad/s should hold the orbit of {orbit.in_short}, but "
            f"the rates of (r, theta, z, chi, v) are {left.tolist()} there"
        )
    return steady


def vanishing_rates(model: str) -> RelativeState:
    """Which rates are 0 at every steady orbit by the structure of the model's expressions.

    There cos(theta) and chi are 0 exactly; every other number, the turn rate included, stays a
    symbol. So what is said here holds of real numbers, where a value computed with rounding only
    says that a rate is small. The bearing's rate vanishes if it is a drift plus the turn rate.

    Args:
        model: Name of a relative model.
    """
    place = RelativeState(*(ca.SX.sym(name) for name in STATE_NAMES))

    def applied(code: int, *operands: ca.SX) -> ca.SX:
        if code == ca.OP_COS and ca.is_equal(operands[0], place.bearing):
            return ca.SX(0)
        return ca.SX.unary(code, *operands) if len(operands) == 1 else ca.SX.binary(code, *operands)

    turn = ca.SX.sym("u_psi")
    inputs = [[*place._replace(path_angle=ca.SX(0))], [turn, ca.SX(0), ca.SX(0)]]
    (found,) = evaluate(rates_function(model), inputs, ca.SX, applied)
    rates = RelativeState(*found)
    vanish = RelativeState(*(rate.is_zero() for rate in rates))
    return vanish._replace(bearing=ca.jacobian(rates.bearing, turn).is_one())


def error_step(
    model: str, scheme: str, x: ca.SX, u: ca.SX, x_ss: Any, u_ss: Any, step: Any
) -> ca.SX:
    """Tracking-error form of one step, (10)-(11): x+ = Phi(x_ss + x, u_ss + u) - x_ss.

    Args:
        model: Name of a relative model.
        scheme: Name in :data:`SCHEMES`.
        x: Deviation from the steady state, shape (5, 1).
        u: Deviation from the steady inputs, shape (3, 1).
        x_ss: Steady state, shape (5, 1).
        u_ss: Steady inputs, shape (3, 1).
        step: T_s in [s], a number or a symbol.
    """
    return SCHEMES[scheme](rates_function(model), x_ss + x, u_ss + u, step) - x_ss


def error_dynamics(model: str, orbit: Orbit, step: float, scheme: str = "euler") -> ca.Function:
    """Tracking-error form f(x, u) of a model, (10)-(11): x+ = f(x, u), f(0, 0) = 0.

    Args:
        model: Name of a relative model.
        orbit: Reference; x and u are deviations from its steady state and steady inputs.
        step: T_s in [s].
        scheme: Name in :data:`SCHEMES`.

    Returns:
        CasADi function (x (5,), u (3,)) -> x+ (5,).

    Raises:
        ValueError: Unknown model or scheme, or a step that is not positive.
    """
    if scheme not in SCHEMES:
        raise ValueError(f"scheme is {scheme!r}, must be one of {', '.join(SCHEMES)}")
    if not step > 0.0:
        raise ValueError(f"step is {step} s, must be positive")
    x, u = ca.SX.sym("x", NX), ca.SX.sym("u", NU)
    following = orbit_dynamics(model, step, scheme)(x, u, orbit_numbers(model, orbit))
    return ca.Function(f"{model}_{scheme}", [x, u], [following], ["x", "u"], ["x_next"])


def orbit_dynamics(model: str, step: float, scheme: str) -> ca.Function:
    """The same of every orbit: what it depends on is the third argument.

    Args:
        model: Name of a relative model.
        step: T_s in [s].
        scheme: Name in :data:`SCHEMES`.

    Returns:
        CasADi function (x (5,), u (3,), orbit (5,)) -> x+ (5,), where orbit is
        :func:`orbit_numbers`.
    """
    x, u, orbit = ca.SX.sym("x", NX), ca.SX.sym("u", NU), ca.SX.sym("orbit", NX)
    range_, bearing, altitude, speed, turn_rate = ca.vertsplit(orbit)
    x_ss = ca.vertcat(range_, bearing, altitude, 0.0, speed)
    u_ss = ca.vertcat(turn_rate, 0.0, 0.0)
    following = error_step(model, scheme, x, u, x_ss, u_ss, step)
    names = ["x", "u", "orbit"], ["x_next"]
    return ca.Function(f"{model}_{scheme}", [x, u, orbit], [following], *names)


def orbit_numbers(model: str, orbit: Orbit) -> NDArray[np.float64]:
    """What is not zero in x_ss and u_ss of an orbit: r_d, theta_ss, z_d, v_d and the turn rate.

    Args:
        model: Name of a relative model.
        orbit: Reference.

    Returns:
        Shape (5,), in [m], [rad], [m], [m/s] and [rad/s].
    """
    range_, bearing, altitude, _, speed = orbit.steady_state
    turn_rate, _, _ = steady_inputs(model, orbit)
    return np.array([range_, bearing, altitude, speed, turn_rate])


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
