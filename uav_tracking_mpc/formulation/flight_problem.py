r"""The tracking problem of a real flight: drift, envelope, lag, and an artificial orbit.

State (x, y, z, psi, chi, v), followed by the three lagged rates if the aircraft has any: position
relative to the target in the axes of ``map`` (range and bearing are singular above the target),
heading, path angle, airspeed. The error is the paper's (Section 3.1) of the motion relative to the
target: range, direction of the relative velocity against the orbit's tangent, altitude, path angle,
airspeed. The true periodic orbit under drift has no error and is paid nothing, its turn rate being
fed forward; without drift the stage cost is that of (14).

The inputs are shares, from -1 to 1, of what the aircraft can do in its present state: of the turn
rate that bank and yaw rate allow, of the path-angle rate, and of the span of the acceleration that
is left between the limits of the specific force. So these coupled limits are a box, which every
plan obeys. Airspeed, path angle, height, distance and fence are exact soft constraints, since a
flight may begin outside of them.

Terminal ingredient: the optimiser chooses an orbit (d_a, z_a, v_a), tracks it, pays for its
distance to the wanted one and must end on it, flying as the periodic orbit does. From any state in
which the aircraft can still turn there is such a plan, and the orbit continues every plan: feasible
once is feasible for ever (Limon et al. 2008, 2018; Koehler, Mueller, Allgoewer 2020).

Everything that may change in flight is a parameter of one compiled problem, see
:class:`FlightData`.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from types import ModuleType, SimpleNamespace
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike, NDArray

from uav_tracking_mpc.dynamics.drifting_orbit import orbit_motion
from uav_tracking_mpc.dynamics.lagged_vehicle import advance
from uav_tracking_mpc.limits._envelope import DRIFT_SHARE, GRAVITY, TURN_RATE_SHARE
from uav_tracking_mpc.mpc.problem import Inequality, OptimalControlProblem

# Decisions are scaled to be of one size: [m], [m], [m/s].
DECISION_SCALE = np.array([100.0, 30.0, 3.0])
RADIUS_LIMITS, ALTITUDE_LIMIT, SPEED_LIMITS = (1.0, 2e4), 1e4, (0.1, 400.0)
SMALL = 0.01  # [m] keeps distances smooth where they vanish
LEAST_SPAN = 0.1  # [m/s^2] of acceleration, where limits contradict each other
TURN_RATE_BLEND, ACCELERATION_BLEND = 0.02, 0.2  # [rad/s], [m/s^2] over which limits merge
LEAST_AIRSPEED = 0.5  # [m/s] below which the bank's limit grows no more


@dataclass(frozen=True)
class FlightData:
    """What one stage of the problem is told, in the order of the problem's parameter p.

    Attributes:
        drift: c, shape (3,), in [m/s].
        drift_rate: c', shape (3,), in [m/s^2].
        orbit: (r_d, z_d, v_d), shape (3,).
        sense: 1 counter-clockwise, -1 clockwise.
        state_weights: Diagonal of Q, shape (5,).
        input_weights: Diagonal of R, shape (3,).
        offset_weights: Of the artificial orbit's distance to the wanted one, shape (3,).
        offset_reach: Distance in range, altitude, airspeed at which that cost turns from quadratic
            to linear, shape (3,).
        airspeed: Least and greatest, shape (2,).
        path_angle: Least and greatest, shape (2,).
        lateral: g tan(bank_max) in [m/s^2].
        rates: Greatest yaw rate and path-angle rate, shape (2,).
        acceleration: Least and greatest, shape (2,).
        force_min: Least specific force at v = 0, and its slope over v, shape (2,).
        force_max: Greatest, likewise.
        floor: Least height above the target in [m].
        distance: Least distance to the target in [m].
        fence: Centre relative to the target (x, y) and radius, shape (3,), in [m].
    """

    drift: ArrayLike
    drift_rate: ArrayLike
    orbit: ArrayLike
    sense: ArrayLike
    state_weights: ArrayLike
    input_weights: ArrayLike
    offset_weights: ArrayLike
    offset_reach: ArrayLike
    airspeed: ArrayLike
    path_angle: ArrayLike
    lateral: ArrayLike
    rates: ArrayLike
    acceleration: ArrayLike
    force_min: ArrayLike
    force_max: ArrayLike
    floor: ArrayLike
    distance: ArrayLike
    fence: ArrayLike

    def vector(self) -> NDArray[np.float64]:
        """The values one after the other, shape (np,)."""
        values = [getattr(self, name) for name in SIZES]
        return np.concatenate([np.asarray(value, dtype=float).ravel() for value in values])


SIZES = {
    "drift": 3, "drift_rate": 3, "orbit": 3, "sense": 1, "state_weights": 5, "input_weights": 3,
    "offset_weights": 3, "offset_reach": 3, "airspeed": 2, "path_angle": 2, "lateral": 1,
    "rates": 2, "acceleration": 2, "force_min": 2, "force_max": 2, "floor": 1, "distance": 1,
    "fence": 3,
}  # fmt: skip
assert list(SIZES) == [field.name for field in dataclasses.fields(FlightData)]
PARAMETERS = sum(SIZES.values())
_STARTS = dict(zip(SIZES, np.cumsum([0, *SIZES.values()]), strict=False))
WHERE = {name: slice(int(_STARTS[name]), int(_STARTS[name]) + size) for name, size in SIZES.items()}


def flight_problem(
    horizon: int, step: float, lag: Sequence[float], penalty: float
) -> OptimalControlProblem:
    """The problem of the module's docstring.

    Args:
        horizon: N.
        step: T_s in [s].
        lag: Time constants of turn rate, path-angle rate and acceleration in [s]; empty for none.
        penalty: Of a violated soft constraint, per m/s, 0.1 rad, 5 m or 10 m.
    """
    symbols = {name: ca.SX.sym(name, size) for name, size in SIZES.items()}
    p = SimpleNamespace(**symbols)
    state, shares = ca.SX.sym("x", 9 if lag else 6), ca.SX.sym("u", 3)
    decision = ca.SX.sym("a", 3)
    x, y, z, psi, chi, v = ca.vertsplit(state)[:6]
    d_a, z_a, v_a = (decision[k] * DECISION_SCALE[k] for k in range(3))
    inputs = physical_inputs(shares, chi, v, p)

    following = advance(
        ca.vertsplit(state), inputs, step, lag, ca.vertsplit(p.drift), ca.vertsplit(p.drift_rate),
        symbolic=True,
    )  # fmt: skip

    d = ca.sqrt(x**2 + y**2 + SMALL**2)
    r = ca.sqrt(x**2 + y**2 + z**2 + SMALL**2)
    orbit = orbit_motion((x / d, y / d), p.sense, d_a, v_a, p.drift, p.drift_rate)
    w_x = v * ca.cos(chi) * ca.cos(psi) + p.drift[0]
    w_y = v * ca.cos(chi) * ca.sin(psi) + p.drift[1]
    (t_x, t_y) = orbit.tangent
    # theta - theta_ss of the relative velocity, in (-pi, pi]
    bearing = ca.atan2(t_x * w_y - t_y * w_x, t_x * w_x + t_y * w_y)
    r_a = ca.sqrt(d_a**2 + z_a**2)
    error = ca.vertcat(r - r_a, bearing, z - z_a, chi - orbit.path_angle, v - v_a)
    # Held commands lag by tau, and by half a step behind what they follow.
    lead = (lag[0] if lag else 0.0) + 0.5 * step
    deviation = ca.vertcat(
        inputs[0] - orbit.turn_rate - lead * orbit.turn_acceleration, inputs[1], inputs[2]
    )
    offset = ca.vertcat(r_a - p.orbit[0], z_a - p.orbit[1], v_a - p.orbit[2])
    settled = [(r - r_a) / 10.0, bearing, (z - z_a) / 10.0, chi - orbit.path_angle, v - v_a]
    if lag:
        settled += [state[6] - orbit.turn_rate, state[7], state[8]]
    drift = ca.sqrt(p.drift[0] ** 2 + p.drift[1] ** 2 + SMALL**2)
    # Against both limits on the turn rate at v_a, yaw rate and bank.
    sharpest = (v_a + drift) ** 2 / (TURN_RATE_SHARE * d_a * v_a)
    sharpest = ca.vertcat(sharpest / p.rates[0], sharpest * v_a / p.lateral) - 1.0
    return OptimalControlProblem(
        state=state,
        inputs=shares,
        next_state=ca.vertcat(*following),
        stage_cost=ca.dot(p.state_weights, error**2) + ca.dot(p.input_weights, deviation**2),
        terminal_cost=ca.dot(p.offset_weights, _distance(offset, p.offset_reach)),
        horizon=horizon,
        step=step,
        input_lower=-np.ones(3),
        input_upper=np.ones(3),
        parameter=ca.vertcat(*symbols.values()),
        decision=decision,
        decision_lower=np.array([RADIUS_LIMITS[0], -ALTITUDE_LIMIT, SPEED_LIMITS[0]])
        / DECISION_SCALE,
        decision_upper=np.array([RADIUS_LIMITS[1], ALTITUDE_LIMIT, SPEED_LIMITS[1]])
        / DECISION_SCALE,
        decision_guess=np.array([3.0, 3.0, 6.0]),
        stage_inequalities=(
            Inequality(ca.vertcat(p.airspeed[0] - v, v - p.airspeed[1]), penalty, "airspeed"),
            Inequality(
                10.0 * ca.vertcat(p.path_angle[0] - chi, chi - p.path_angle[1]),
                penalty,
                "path angle",
            ),
            Inequality((p.floor - z) / 5.0, penalty, "height"),
            Inequality((p.distance - r) / 5.0, penalty, "distance"),
            Inequality(_beyond_fence(x, y, p) / 10.0, penalty, "fence"),
        ),
        terminal_inequalities=(
            Inequality(sharpest, None, "sharpest turn of the orbit"),
            Inequality(
                ca.vertcat(p.airspeed[0] - v_a, v_a - p.airspeed[1], drift - DRIFT_SHARE * v_a),
                None,
                "airspeed on the orbit",
            ),
            Inequality((p.floor - z_a) / 5.0, penalty, "height of the orbit"),
            Inequality((p.distance - r_a) / 5.0, penalty, "distance of the orbit"),
            Inequality(
                (ca.sqrt(p.fence[0] ** 2 + p.fence[1] ** 2 + SMALL**2) + d_a - p.fence[2]) / 10.0,
                penalty,
                "fence about the orbit",
            ),
        ),
        terminal_equality=ca.vertcat(*settled),
        continuation=_shares(
            [orbit.turn_rate + lead * orbit.turn_acceleration, 0.0, 0.0], chi, v, p
        ),
    )


def physical_inputs(
    shares: Any, path_angle: Any, airspeed: Any, p: Any, xp: ModuleType = ca
) -> list[Any]:
    """(u_psi, u_chi, u_v) of the input shares in a state: see :func:`input_span`."""
    middle, half = input_span(path_angle, airspeed, p, xp)
    return [middle[axis] + half[axis] * shares[axis] for axis in range(3)]


def input_span(
    path_angle: Any, airspeed: Any, p: Any, xp: ModuleType = ca
) -> tuple[list[Any], list[Any]]:
    """Middle and half width of what each of (u_psi, u_chi, u_v) can be in a state.

    The turn rate is at most g tan(bank_max) / v and the yaw rate's limit; the acceleration obeys
    its own limits and force_min <= g sin(chi) + u_v <= force_max.

    Args:
        path_angle: chi in [rad].
        airspeed: v in [m/s].
        p: Limits, with the attributes of :class:`FlightData`.
        xp: ``casadi`` for expressions, ``numpy`` for numbers or arrays of them.
    """
    turn = _least(p.rates[0], p.lateral / xp.fmax(airspeed, LEAST_AIRSPEED), TURN_RATE_BLEND, xp)
    weight = GRAVITY * xp.sin(path_angle)
    least = p.force_min[0] + p.force_min[1] * airspeed - weight
    greatest = p.force_max[0] + p.force_max[1] * airspeed - weight
    lower = -_least(-least, -p.acceleration[0], ACCELERATION_BLEND, xp)
    lower = xp.fmin(lower, p.acceleration[1] - LEAST_SPAN)
    upper = _least(greatest, p.acceleration[1], ACCELERATION_BLEND, xp)
    upper = xp.fmax(upper, lower + LEAST_SPAN)
    middle, half = 0.5 * (lower + upper), 0.5 * (upper - lower)
    return [0.0 * turn, 0.0 * turn, middle], [turn, p.rates[1] + 0.0 * turn, half]


def _shares(inputs: list[Any], path_angle: Any, airspeed: Any, p: Any) -> ca.SX:
    """Input shares of (u_psi, u_chi, u_v) in a state: the inverse of :func:`physical_inputs`."""
    middle, half = input_span(path_angle, airspeed, p)
    return ca.vertcat(*[(inputs[axis] - middle[axis]) / half[axis] for axis in range(3)])


def _least(a: Any, b: Any, blend: float, xp: ModuleType) -> Any:
    """Smooth minimum, never above min(a, b), at most blend / 2 below it (where a = b).

    Plans like to stay where one limit takes over from another; a kink there would leave Newton's
    method without a derivative.
    """
    return 0.5 * (a + b - xp.sqrt((a - b) ** 2 + blend**2))


def _distance(offset: ca.SX, reach: ca.SX) -> ca.SX:
    """Pseudo-Huber: offset^2 near 0, 2 reach |offset| far away."""
    # 2 reach^2 (sqrt(1 + (offset / reach)^2) - 1) without its cancellation
    return 2.0 * offset**2 / (1.0 + ca.sqrt(1.0 + (offset / reach) ** 2))


def _beyond_fence(x: ca.SX, y: ca.SX, p: SimpleNamespace) -> ca.SX:
    return ca.sqrt((x - p.fence[0]) ** 2 + (y - p.fence[1]) ** 2 + SMALL**2) - p.fence[2]
