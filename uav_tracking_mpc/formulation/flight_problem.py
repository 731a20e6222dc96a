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

r"""The tracking problem of a real flight: drift, envelope, lag, and an artificial orbit.

The state is that of a :class:`~uav_tracking_mpc.dynamics.vehicle_models.VehicleModel`: position
relative to the target in the axes of ``map`` (range and bearing are singular above the target),
heading, path angle, airspeed, and what the model adds, such as rates that lag. The error is the
paper's (Section 3.1) of the motion relative to the target: range, direction of the relative
velocity against the orbit's tangent, altitude, path angle, airspeed. The true periodic orbit under
drift has no error and is paid nothing, its turn rate being fed forward; without drift the stage
cost is that of (14). Of the height's error a share can be left out of the range's.

Beside the paper's terms the cost pays for how quickly turn rate, path-angle rate and acceleration
change, the orbit's own change being fed forward: bandwidth that a wrong lag, a dead time or noise
would turn into oscillation costs more than it brings. Roll rates beyond their limit and airspeeds
outside of a band about the wanted one are paid for by squares, so much that limits and drift alone
make a plan fly them.

The inputs are shares, from -1 to 1, of what the aircraft can do in its present state
(:func:`~uav_tracking_mpc.limits.envelope.input_span`), so that their coupled limits are a box,
which every plan obeys. The limits of the flight itself, such as airspeed and height, are exact soft
constraints, since a flight may begin outside of them.

Terminal ingredient: the optimiser chooses an orbit (d_a, z_a, v_a), tracks it, pays for its
distance to the wanted one and must end on it, flying as the periodic orbit does. From any state in
which the aircraft can still turn there is such a plan, and the orbit continues every plan: feasible
once is feasible for ever (Limon et al. 2008, 2018; Koehler, Mueller, Allgoewer 2020).

Where the autopilot itself holds altitude and airspeed (a model that says so), the bank alone is an
input, and the model flies towards the altitude and the airspeed that the autopilot was told last.
Costs, limits and terminal equalities that the bank has no say in are left out: every plan must only
end on a circle, at the airspeed and the height at which the aircraft then is. z_a and v_a are what
the autopilot is to be told next: the wanted ones as far as the limits of an orbit allow.

Everything that may change in flight is a parameter of one compiled problem: see
``FlightProblem.where``.
"""

from __future__ import annotations

from collections.abc import Sequence
from types import ModuleType
from typing import Any

import casadi as ca
import numpy as np

from uav_tracking_mpc.dynamics.orbit import DRIFT_SHARE, OrbitMotion, orbit_motion
from uav_tracking_mpc.dynamics.vehicle import air_velocity
from uav_tracking_mpc.dynamics.vehicle_models import Drift, VehicleModel
from uav_tracking_mpc.limits import Bound, Limit, Motion, OrbitShape
from uav_tracking_mpc.limits.envelope import BLENDS, input_span
from uav_tracking_mpc.mpc.problem import Inequality, OptimalControlProblem

DECISION_SCALE = np.array([100.0, 30.0, 3.0])  # m, m, m/s: decisions are scaled to one size
# m, m, m/s: beyond what can be asked for, so that there is an orbit on either side of it.
RADIUS_LIMITS, ALTITUDE_LIMIT, SPEED_LIMITS = (1.0, 2e5), 2e4, (0.1, 400.0)
SQUARES = 0.01  # -, weight of squares by which a limit is passed, as a share of the penalty
BAND_SCALE = 0.3  # m/s by which leaving the airspeed's band is as bad as 1 m/s beyond a limit
SMALL = 0.01  # m, keeps distances smooth where they vanish
OWN_SIZES = {
    "drift": 3,  # c [m/s]
    "drift_rate": 3,  # c' [m/s^2]
    "orbit": 3,  # r_d, z_d, v_d [m, m, m/s]
    "sense": 1,  # 1 counter-clockwise, -1 clockwise
    "state_weights": 5,  # diagonal of Q
    "input_weights": 3,  # diagonal of R
    "rate_weights": 3,  # of the changes of (psi', chi', v')
    "airspeed_band": 2,  # least and greatest airspeed unless forced [m/s]
    "offset_weights": 3,  # of the artificial orbit's distance to the wanted one
    "offset_reach": 3,  # distance at which that cost turns from quadratic to linear
    "slant": 1,  # -, share of the height's error that counts as one of the range, too
    "lead": 1,  # s by which the orbit's turn rate is fed forward
    "onset": 1,  # -, turn acceleration at the beginning of a stage over its mean
}
HELD_SIZES = {
    "held": 2,  # altitude above the target [m] and airspeed [m/s] that the autopilot holds
    "end_height": 1,  # above the target at the end of the plan [m]: the bank has no say in it
}
# How many of the tracking error and of what must settle the bank brings about: range, bearing.
BANKED_ERRORS = 2


class FlightProblem:
    """The problem of the module's docstring, for one model and one set of limits.

    Args:
        model: Of the aircraft; its parameters may change in flight.
        limits: That hold; their parameters may change in flight.
        horizon: N.
        step: T_s in [s].
        penalty: Of a violated soft constraint, per m/s or what a limit counts as alike [-].

    Attributes:
        where: Slices of the parameter p of a stage: the parts of :data:`OWN_SIZES`, with an
            autopilot that holds those of :data:`HELD_SIZES`, ``model``, and a part for each limit
            by :func:`part_of`.
        size: Length of p.
        holds: Whether the autopilot itself holds altitude and airspeed.
        problem: For a solver.
        commands: CasADi function of (x, p, u): (u_psi, u_chi, u_v), see :meth:`inputs`.
        law_stage: CasADi function of (x, w, p), where a law asks for w, (u_psi, u_chi, u_v): the
            input shares nearest to that, and the next state.
        turn_acceleration: CasADi function of (x, p, a): how quickly the turn rate of the orbit
            changes there, in [rad/s^2].
    """

    def __init__(
        self,
        model: VehicleModel,
        limits: Sequence[Limit],
        horizon: int,
        step: float,
        penalty: float,
    ) -> None:
        self.model, self.limits, self.step = model, tuple(limits), step
        self._of_inputs = [limit for limit in limits if type(limit).inputs is not Limit.inputs]
        nowhere = np.zeros((1, 3))
        sizes = {part_of(limit): limit.numbers(nowhere).shape[1] for limit in limits}
        self.holds = model.commanded < len(BLENDS)
        own = OWN_SIZES | HELD_SIZES if self.holds else OWN_SIZES
        sizes = {**own, "model": len(model.numbers(step)), **sizes}
        ends = dict(zip(sizes, np.cumsum([*sizes.values()]).tolist(), strict=True))
        self.where = {name: slice(end - sizes[name], end) for name, end in ends.items()}
        self.size = sum(sizes.values())
        self._penalty = penalty
        self.problem = self._problem(horizon)
        self.law_stage = self._law_stage()

    def _problem(self, horizon: int) -> OptimalControlProblem:
        model, p = self.model, ca.SX.sym("p", self.size)
        names = model.State._fields
        state = model.State(*(ca.SX.sym(name) for name in names))
        shares, decision = ca.SX.sym("u", model.commanded), ca.SX.sym("a", 3)
        self._steered = ca.vertcat(state.x, state.y, state.heading, state.turn_rate, shares)
        told = {name: p[where] for name, where in self.where.items()}
        inputs = self.inputs(shares, state, p, ca)
        at = [ca.vertcat(*state), p, shares]
        self.commands = ca.Function("commands", at, [ca.densify(ca.vertcat(*inputs))])
        drift = Drift(ca.vertsplit(told["drift"]), ca.vertsplit(told["drift_rate"]))
        following = model.step(state, inputs, self.step, told["model"], drift)

        d_a, z_a, v_a = (decision[k] * DECISION_SCALE[k] for k in range(3))
        d = ca.sqrt(state.x**2 + state.y**2 + SMALL**2)
        # The circle at the height and airspeed of the orbit, or at those that the aircraft has.
        speed, range_a = v_a, ca.sqrt(d_a**2 + z_a**2)
        r_a = range_a
        if self.holds:
            level = state.airspeed * ca.cos(state.path_angle)
            speed = ca.sqrt(level**2 + told["drift"][2] ** 2)
            r_a = ca.sqrt(d_a**2 + told["end_height"] ** 2)
        orbit = orbit_motion(
            (state.x / d, state.y / d), told["sense"], d_a, speed, told["drift"], told["drift_rate"]
        )
        error = self._error(state, orbit, told["drift"], (r_a, z_a, v_a), told["slant"])
        turn_rate = orbit.turn_rate + told["lead"] * orbit.turn_acceleration
        self.turn_acceleration = ca.Function(
            "turn_acceleration", [*at[:2], decision], [ca.densify(orbit.turn_acceleration)]
        )
        deviation = ca.vertcat(inputs[0] - turn_rate, inputs[1], inputs[2])
        changes = [
            (after - before) / self.step
            for before, after in zip(state[6:9], following[6:9], strict=True)
        ]
        change = ca.vertcat(changes[0] - orbit.turn_acceleration, changes[1], changes[2])
        motion = _motion(state)._replace(turn_acceleration=told["onset"] * changes[0])
        offset = ca.vertcat(r_a, z_a, v_a) - told["orbit"]
        scaled = [error[0] / 10.0, error[1], error[2] / 10.0, error[3], error[4]]
        free, errors = model.commanded, BANKED_ERRORS if self.holds else len(scaled)
        strength = ca.sqrt(told["drift"][0] ** 2 + told["drift"][1] ** 2 + SMALL**2)
        shape = OrbitShape(d_a, z_a, v_a, range_a, strength)
        lower = np.array([RADIUS_LIMITS[0], -ALTITUDE_LIMIT, SPEED_LIMITS[0]])
        upper = np.array([RADIUS_LIMITS[1], ALTITUDE_LIMIT, SPEED_LIMITS[1]])
        return OptimalControlProblem(
            state=ca.vertcat(*state),
            inputs=shares,
            next_state=ca.vertcat(*following),
            stage_cost=ca.dot(told["state_weights"][:errors], error[:errors] ** 2)
            + ca.dot(told["input_weights"][:free], deviation[:free] ** 2)
            + ca.dot(told["rate_weights"][:free], change[:free] ** 2)
            + self._passed(motion, p),
            terminal_cost=ca.dot(told["offset_weights"], _distance(offset, told["offset_reach"])),
            horizon=horizon,
            step=self.step,
            input_lower=-np.ones(free),
            input_upper=np.ones(free),
            parameter=p,
            decision=decision,
            decision_lower=lower / DECISION_SCALE,
            decision_upper=upper / DECISION_SCALE,
            decision_guess=np.array([3.0, 3.0, 6.0]),
            stage_inequalities=tuple(self._stage_inequalities(motion, p)),
            terminal_inequalities=tuple(self._orbit_inequalities(shape, p)),
            terminal_equality=ca.vertcat(*scaled[:errors], *model.settled(state, orbit)[:free]),
            continuation=self._shares([turn_rate, 0.0, 0.0], state, p),
        )

    def _law_stage(self) -> ca.Function:
        problem, wanted = self.problem, ca.SX.sym("wanted", 3)
        x, p, inputs = problem.state, problem.parameter, ca.vertsplit(wanted)
        shares = self._shares(inputs, self.model.State(*ca.vertsplit(x)), p)
        nearest = ca.fmin(ca.fmax(shares, problem.input_lower), problem.input_upper)
        step = ca.Function("step", [x, problem.inputs, p], [problem.next_state])
        results = [ca.densify(nearest), ca.densify(step(x, nearest, p))]
        return ca.Function("law_stage", [x, wanted, p], results)

    def _error(
        self, state: Any, orbit: OrbitMotion, drift: ca.SX, wanted: Sequence[Any], slant: ca.SX
    ) -> ca.SX:
        """Tracking error x of Section 3.1, of the motion relative to the target."""
        r_a, z_a, v_a = wanted
        height = z_a + slant * (state.z - z_a)
        r = ca.sqrt(state.x**2 + state.y**2 + height**2 + SMALL**2)
        east, north, _ = air_velocity(state.heading, state.path_angle, state.airspeed, ca)
        w_x, w_y = east + drift[0], north + drift[1]
        t_x, t_y = orbit.tangent
        # theta - theta_ss of the relative velocity, in (-pi, pi]
        bearing = ca.atan2(t_x * w_y - t_y * w_x, t_x * w_x + t_y * w_y)
        return ca.vertcat(
            r - r_a, bearing, state.z - z_a, state.path_angle - orbit.path_angle,
            state.airspeed - v_a,
        )  # fmt: skip

    def inputs(self, shares: Any, state: Any, p: Any, xp: ModuleType = np) -> list[Any]:
        """(u_psi, u_chi, u_v) of plans.

        Args:
            shares: Of what each input can be, from -1 to 1, shape (k,) or (k, n).
            state: A ``State`` of the model, of numbers, arrays of shape (n,), or symbols.
            p: Parameter of the stage, shape (np,), or of the stages, shape (np, n).
            xp: ``casadi`` for symbols, ``numpy`` for numbers.

        Returns:
            Three values, in [rad/s, rad/s, m/s^2], scalar or of shape (n,).
        """
        middle, half = self.span(state, p, xp)
        free = range(self.model.commanded)
        commanded = [middle[axis] + half[axis] * shares[axis] for axis in free]
        if not self.holds:
            return commanded
        held, numbers, drift = (p[self.where[name]] for name in ("held", "model", "drift"))
        return [*commanded, *self.model.held(state, held[0], held[1], numbers, drift)]

    def _shares(self, inputs: Sequence[Any], state: Any, p: ca.SX) -> ca.SX:
        """Input shares of (u_psi, u_chi, u_v) in a state."""
        middle, half = self.span(state, p, ca)
        free = range(self.model.commanded)
        return ca.vertcat(*[(inputs[axis] - middle[axis]) / half[axis] for axis in free])

    def span(self, state: Any, p: Any, xp: ModuleType = np) -> tuple[list[Any], list[Any]]:
        """Middle and half width of (u_psi, u_chi, u_v) in states: see :func:`input_span`.

        Args:
            state: A ``State`` of the model, of numbers, arrays of shape (n,), or symbols.
            p: Parameter of the stage, shape (np,), or of the stages, shape (np, n).
            xp: ``casadi`` for symbols, ``numpy`` for numbers.

        Returns:
            Three values each, in [rad/s, rad/s, m/s^2], scalar or of shape (n,).
        """
        numbers = [p[self.where[part_of(limit)]] for limit in self._of_inputs]
        return input_span(self._of_inputs, numbers, _motion(state), xp)

    def _stage_inequalities(self, motion: Motion, p: ca.SX) -> list[Inequality]:
        return [
            _inequality(bound, self._penalty, limit.label)
            for limit, bound in self._stage_bounds(motion, p)
            if not limit.by_squares
        ]

    def _passed(self, motion: Motion, p: ca.SX) -> ca.SX:
        """Cost of what is paid for by squares: the airspeed's band, and limits that say so."""
        least, most = ca.vertsplit(p[self.where["airspeed_band"]])
        band = Bound(motion.airspeed, least, most, BAND_SCALE)
        bounds = [] if self.holds else [band]
        bounds += [bound for limit, bound in self._stage_bounds(motion, p) if limit.by_squares]
        sides = ca.vertcat(*(side for bound in bounds for side in bound.inequalities()))
        return SQUARES * self._penalty * ca.sum1(_rounded_square(sides))

    def _stage_bounds(self, motion: Motion, p: ca.SX) -> list[tuple[Limit, Bound]]:
        found = []
        for limit in self.limits:
            bound = limit.stage(motion, p[self.where[part_of(limit)]], ca)
            if bound is None or (self.holds and not ca.depends_on(bound.value, self._steered)):
                continue
            found.append((limit, bound))
        return found

    def _orbit_inequalities(self, shape: OrbitShape, p: ca.SX) -> list[Inequality]:
        too_much = shape.drift - DRIFT_SHARE * shape.airspeed
        found = [Inequality(too_much, None, "drift about the orbit")]
        for limit in self.limits:
            bound = limit.orbit(shape, p[self.where[part_of(limit)]], ca)
            if bound is not None:
                penalty = None if limit.hard_on_orbit else self._penalty
                found.append(_inequality(bound, penalty, f"{limit.label} on the orbit"))
        return found


def part_of(limit: Limit) -> str:
    """Name of a limit's part of the parameter vector.

    Args:
        limit: The limit.
    """
    return f"limit {limit.name}"


def _motion(state: Any) -> Motion:
    x, y, z, _, path_angle, airspeed, turn_rate, _, acceleration = state[:9]
    return Motion(x, y, z, path_angle, airspeed, turn_rate, acceleration)


def _inequality(bound: Bound, penalty: float | None, name: str) -> Inequality:
    return Inequality(ca.vertcat(*bound.inequalities()), penalty, name)


def _rounded_square(side: ca.SX) -> ca.SX:
    """Cost of passing a limit: 0 inside, at last a square, and twice continuously differentiable.

    Its curvature rises from 0 to 2 (smoothstep) while the side goes from -1/2 to 3/2. That of
    max(0, side)^2 jumps at 0, where plans like to stay, and Newton steps fail there by the dozen.

    Args:
        side: By how much each limit is passed, in its scale, negative inside, shape (n, 1).
    """
    begun = ca.fmax(side + 0.5, 0.0)
    rising = ca.fmin(begun, 2.0)
    beyond = begun - rising
    return rising**4 * (5.0 - rising) / 40.0 + beyond * (2.0 + beyond)


def _distance(offset: ca.SX, reach: ca.SX) -> ca.SX:
    """Pseudo-Huber: offset^2 near 0, 2 reach |offset| far away."""
    # 2 reach^2 (sqrt(1 + (offset / reach)^2) - 1) without its cancellation
    return 2.0 * offset**2 / (1.0 + ca.sqrt(1.0 + (offset / reach) ** 2))
