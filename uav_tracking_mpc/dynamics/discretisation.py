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

"""Discrete-time models: forward Euler (10), Runge-Kutta 4, and the linearisation (12)."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.dynamics.orbit import Orbit
from uav_tracking_mpc.dynamics.relative import NU, NX, rates_function, steady_inputs


def euler(rates: ca.Function, state: ca.SX, inputs: ca.SX, step: Any) -> ca.SX:
    """One forward Euler step, as in (10).

    Args:
        rates: CasADi function (state, inputs) -> time derivative of the state.
        state: Where the step begins, shape (nx, 1).
        inputs: Held over the step, shape (nu, 1).
        step: T_s in [s], a number or a symbol.
    """
    return state + step * rates(state, inputs)


def runge_kutta4(rates: ca.Function, state: ca.SX, inputs: ca.SX, step: Any) -> ca.SX:
    """One classical Runge-Kutta step with the inputs held.

    Args:
        rates: CasADi function (state, inputs) -> time derivative of the state.
        state: Where the step begins, shape (nx, 1).
        inputs: Held over the step, shape (nu, 1).
        step: T_s in [s], a number or a symbol.
    """
    k1 = rates(state, inputs)
    k2 = rates(state + 0.5 * step * k1, inputs)
    k3 = rates(state + 0.5 * step * k2, inputs)
    k4 = rates(state + step * k3, inputs)
    return state + step / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)


SCHEMES: dict[str, Callable[[ca.Function, ca.SX, ca.SX, Any], ca.SX]] = {
    "euler": euler,
    "rk4": runge_kutta4,
}


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
    x_ss, u_ss = ca.DM(orbit.steady_state), ca.DM(steady_inputs(model, orbit))
    following = error_step(model, scheme, x, u, x_ss, u_ss, step)
    return ca.Function(f"{model}_{scheme}", [x, u], [following], ["x", "u"], ["x_next"])


def orbit_dynamics(model: str, step: float, scheme: str = "euler") -> ca.Function:
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


def linearise(
    dynamics: ca.Function, state: NDArray | None = None, inputs: NDArray | None = None
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """A and B of (12): Jacobians of f by automatic differentiation.

    Args:
        dynamics: CasADi function (x, u) -> x+.
        state: Where to linearise, shape (nx,); the origin by default.
        inputs: Likewise, shape (nu,).

    Returns:
        A, shape (nx, nx), and B, shape (nx, nu).
    """
    x, u = ca.SX.sym("x", dynamics.size1_in(0)), ca.SX.sym("u", dynamics.size1_in(1))
    following = dynamics(x, u)
    jacobians = ca.Function("AB", [x, u], [ca.jacobian(following, x), ca.jacobian(following, u)])
    a, b = jacobians(0 if state is None else state, 0 if inputs is None else inputs)
    return np.array(a), np.array(b)
