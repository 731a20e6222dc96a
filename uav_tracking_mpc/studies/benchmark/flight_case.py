"""A flight problem with everything in it: drift, envelope, and an artificial orbit.

State (x, y, z, psi, chi, v): position relative to the target in the axes of ``map``, heading, path
angle, airspeed. Inputs are those of the vehicle (3). The relative velocity is w = v_air + c with
the drift c = wind - v_target, a parameter of every stage. Position is Cartesian because range and
bearing are singular above the target, and because their rates depend on where round the orbit the
drift comes from.

The optimiser chooses an artificial orbit a = (r_a, z_a, v_a), tracks it, pays for its distance to
the wanted orbit, and must end on it: range r_a, relative velocity along the tangent, height z_a,
level, airspeed v_a. Under drift that is the point where the plan touches the periodic orbit, and
the orbit must be flyable all the way round: the sharpest turn is where the relative speed is
v_a + |c|.
"""

from __future__ import annotations

import math

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.dynamics.discretisation import runge_kutta4
from uav_tracking_mpc.mpc.problem import Inequality, OptimalControlProblem

GRAVITY = 9.81  # [m/s^2]
BANK_LIMIT = math.radians(15.0)
PATH_ANGLE_LIMIT = 0.35  # [rad]
SPEED_LIMITS = (2.0, 8.0)  # airspeed [m/s]
PENALTY = 100.0  # of a violation of speed or path angle, per m/s or rad
DRIFT = np.array([0.8, -0.5, 0.0])  # [m/s]
SLOW = 0.25  # [m^2/s^2] keeps the direction of the relative velocity smooth where it vanishes


def flight_problem(
    horizon: int,
    step: float = 1.0,
    orbit: tuple[float, float, float] = (150.0, 50.0, 4.0),
    input_limits: tuple[float, float, float] = (math.pi / 4, math.pi / 4, 1.0),
) -> OptimalControlProblem:
    """The problem of the module's docstring.

    Args:
        horizon: N.
        step: T_s in [s].
        orbit: Wanted range [m], height [m] and airspeed [m/s].
        input_limits: Bounds of |u_psi|, |u_chi| in [rad/s] and |u_v| in [m/s^2].
    """
    state, inputs = ca.SX.sym("x", 6), ca.SX.sym("u", 3)
    drift, artificial = ca.SX.sym("c", 3), ca.SX.sym("a", 3)
    x, y, z, psi, chi, v = ca.vertsplit(state)
    r_a, z_a, v_a = ca.vertsplit(artificial)
    d_a = ca.sqrt(r_a**2 - z_a**2)

    air = ca.vertcat(v * ca.cos(chi) * ca.cos(psi), v * ca.cos(chi) * ca.sin(psi), v * ca.sin(chi))
    rates = ca.Function("rates", [state, inputs], [ca.vertcat(air, inputs)])  # (3)
    # Position does not enter its own rate, so the drift adds exactly.
    following = runge_kutta4(rates, state, inputs, step) + ca.vertcat(step * drift, 0, 0, 0)

    r, d = ca.sqrt(x**2 + y**2 + z**2), ca.sqrt(x**2 + y**2 + 1e-6)
    w_x, w_y = air[0] + drift[0], air[1] + drift[1]
    w = ca.sqrt(w_x**2 + w_y**2 + SLOW)
    along = (y * w_x - x * w_y) / (d * w)  # 1 where w follows the clockwise tangent
    outward = (x * w_x + y * w_y) / (d * w)
    turn = inputs[0] + v_a / d_a  # deviation from the steady turn of the orbit
    stage_cost = (
        0.008 * (r - r_a) ** 2
        + 0.18 * (1.0 - along)
        + 0.05 * (z - z_a) ** 2
        + 0.04 * chi**2
        + 0.9 * (v - v_a) ** 2
        + turn**2
        + inputs[1] ** 2
        + inputs[2] ** 2
    )
    offset = (
        0.06 * (r_a - orbit[0]) ** 2 + 0.5 * (z_a - orbit[1]) ** 2 + 10.0 * (v_a - orbit[2]) ** 2
    )
    lateral = GRAVITY * math.tan(BANK_LIMIT)
    limits = np.array(input_limits)
    return OptimalControlProblem(
        state=state,
        inputs=inputs,
        next_state=following,
        stage_cost=stage_cost,
        terminal_cost=offset,
        horizon=horizon,
        step=step,
        input_lower=-limits,
        input_upper=limits,
        parameter=drift,
        decision=artificial,
        decision_lower=np.array([100.0, 5.0, SPEED_LIMITS[0]]),
        decision_upper=np.array([450.0, 95.0, SPEED_LIMITS[1]]),
        decision_guess=np.array(orbit),
        state_goal=np.array(
            [0.0, math.sqrt(orbit[0] ** 2 - orbit[1] ** 2), orbit[1], 0.0, 0.0, orbit[2]]
        ),
        stage_inequalities=(
            Inequality(ca.vertcat(SPEED_LIMITS[0] - v, v - SPEED_LIMITS[1]), PENALTY, "speed"),
            Inequality(
                ca.vertcat(-PATH_ANGLE_LIMIT - chi, chi - PATH_ANGLE_LIMIT), PENALTY, "path angle"
            ),
            Inequality(ca.vertcat(-inputs[0] * v - lateral, inputs[0] * v - lateral), None, "bank"),
        ),
        terminal_inequalities=(
            Inequality(
                ((v_a + ca.norm_2(drift)) ** 2 - lateral * d_a) / 10.0, None, "sharpest turn"
            ),
        ),
        terminal_equality=ca.vertcat((r - r_a) / 10.0, outward, (z - z_a) / 10.0, chi, v - v_a),
    )


def flight_state(
    relative: NDArray[np.float64], azimuth: float, drift: NDArray[np.float64] = DRIFT
) -> NDArray[np.float64]:
    """State of the flight problem from (r, theta, z, chi, v) and the azimuth phi of the vehicle."""
    r, theta, z, chi, v = relative
    d = math.sqrt(r**2 - z**2)
    return np.array(
        [d * math.cos(azimuth), d * math.sin(azimuth), z, theta + azimuth + math.pi, chi, v]
    )
