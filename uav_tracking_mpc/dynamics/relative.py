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

"""Motion of the UAV relative to its target, Section 3 of the paper: coordinates and steady orbits.

The models themselves stand in :mod:`uav_tracking_mpc.dynamics.relative_models`.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike, NDArray

from uav_tracking_mpc.dynamics.angles import wrap_angle
from uav_tracking_mpc.dynamics.orbit import Orbit
from uav_tracking_mpc.dynamics.vehicle import INPUT_NAMES
from uav_tracking_mpc.parameters.registry import RELATIVE_MODEL


class RelativeState(NamedTuple):
    """State (r, theta, z, chi, v) by name; an array of shape (5,) in this order is the same.

    Attributes:
        range: r, distance to the target [m].
        bearing: theta = psi - phi - pi, wrapped to (-pi, pi] [rad].
        altitude: z, height above the target [m].
        path_angle: chi, positive when climbing [rad].
        speed: v [m/s].
    """

    range: Any
    bearing: Any
    altitude: Any
    path_angle: Any
    speed: Any


STATE_NAMES = RelativeState._fields
NX, NU = len(STATE_NAMES), len(INPUT_NAMES)
_BEARING = STATE_NAMES.index("bearing")


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


def steady_inputs(model: str, orbit: Orbit) -> NDArray[np.float64]:
    """u_ss, shape (3,), that holds the orbit in the given model [rad/s, rad/s, m/s^2].

    The turn rate cancels the model's own drift in bearing: every model has theta' = ... + u_psi.

    Args:
        model: Name of a relative model.
        orbit: The orbit to hold.
    """
    drift = RelativeState(*rates_function(model)(orbit.steady_state, np.zeros(NU)).full().ravel())
    return np.array([-drift.bearing, 0.0, 0.0])


def vanishing_rates(model: str) -> RelativeState:
    """Which rates are 0 at every steady orbit by the structure of the model's expressions.

    There cos(theta) and chi are 0 exactly; every other number stays a symbol. So what is said here
    holds of real numbers, where a value computed with rounding only says that a rate is small.

    Args:
        model: Name of a relative model.
    """
    rates = rates_function(model)
    place = RelativeState(*(ca.SX.sym(name) for name in STATE_NAMES))
    inputs = [ca.vertcat(*place._replace(path_angle=ca.SX(0))), ca.SX(NU, 1)]
    work: dict[int, ca.SX] = {}
    found = [ca.SX(0)] * NX
    for k in range(rates.n_instructions()):
        code = rates.instruction_id(k)
        ins, outs = rates.instruction_input(k), rates.instruction_output(k)
        if code == ca.OP_OUTPUT:
            found[outs[1]] = work[ins[0]]
        elif code == ca.OP_INPUT:
            work[outs[0]] = inputs[ins[0]][ins[1]]
        elif code == ca.OP_CONST:
            work[outs[0]] = ca.SX(rates.instruction_constant(k))
        elif code == ca.OP_COS and ca.is_equal(work[ins[0]], place.bearing):
            work[outs[0]] = ca.SX(0)
        elif len(ins) == 1:
            work[outs[0]] = ca.SX.unary(code, work[ins[0]])
        else:
            work[outs[0]] = ca.SX.binary(code, *(work[i] for i in ins))
    return RelativeState(*(entry.is_zero() for entry in found))


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
