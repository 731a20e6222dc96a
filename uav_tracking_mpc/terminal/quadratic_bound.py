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

r"""The one kind of inequality that has to be proved, tested on boxes with intervals.

.. math:: |f(x, Kx) - C x|_P^2 \le x' N x \quad \text{for every } x \text{ with } x' P x \le \alpha

- C = 0, N = P - Q - K'RK - s P: the direct condition V_f(f) - V_f(x) + L(x, Kx) <= -s V_f(x), all
  that the proofs of Theorems 2 and 3 use of (30);
- C = A_K, N = L^2 P: the Lipschitz bound |g(x)|_P <= L |x|_P of (27) and (31).

**Away from the origin.** On a box c + d, \|d_i\| <= h_i, Taylor's theorem gives F = a + J d + e
with \|e\|_P <= E from the Hessians over the whole box. For any t > 0 and m >= 0

.. math:: |F|_P^2 - x'Nx \le q(d) = (1 + t)|a + Jd|_P^2 + (1 + 1/t) E^2 - x'Nx + m(\alpha - x'Px)

on X_f, since the last bracket is not negative there. Where q is not concave a diagonal D is
added: d'Dd <= sum D_ii h_i^2. A concave q lies below its tangent plane at any point, so the
largest value of the plane on the box bounds it. The numbers t, m, D and the point of tangency are
floating-point guesses: any choice is sound, a bad one only proves less. So the quadratic part is
handled exactly whatever the size of the box; only variables in which the model curves need be cut
small.

**At the origin** the inequality is homogeneous: F(x) = (F'(0) + G(x)) x with rows G_k = x'H_k/2,
and N - (F'(0) + G)'P(F'(0) + G) is to be positive definite for every G in the enclosure.
"""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.dynamics.orbit import Orbit
from uav_tracking_mpc.dynamics.relative import (
    NU,
    NX,
    STATE_NAMES,
    error_step,
    rates_function,
    vanishing_rates,
)
from uav_tracking_mpc.terminal.interval import (
    Interval,
    definite,
    dot,
    evaluate,
    inverse_of,
    product,
    quadratic,
    times,
    total,
    vector,
    with_diagonal,
)

HALF_TURN = Interval(np.nextafter(np.pi, 3.0), np.nextafter(np.pi, 4.0))
UNIT = Interval(-1.0, 1.0)
_RANGE = range(NX)


class ClosedLoop:
    """f(x, Kx) of (10) in error form, its Jacobian and Hessians, on many boxes at once.

    (10) in error form is f(x, u) = Phi(x_ss + x, u_ss + u) - x_ss, Phi one step of the model. The
    exact values are put in: theta_ss is pi/2, not the double nearest to it, and u_ss is the turn
    rate that cancels the drift exactly. Then f(0, 0) = 0 holds as an identity: a steady state of
    the rates is a fixed point of every scheme.

    Args:
        model: Name of a relative model.
        scheme: Name in :data:`uav_tracking_mpc.symbolic.functions.SCHEMES`.
        orbit: Reference.
        step: T_s in [s], taken as the exact double.
        gain: K, shape (3, 5), taken as exact doubles.

    Raises:
        ArithmeticError: The model's rates do not vanish there: no steady state.
    """

    def __init__(
        self, model: str, scheme: str, orbit: Orbit, step: float, gain: NDArray[np.float64]
    ) -> None:
        place, self.steady_inputs = steady_intervals(model, orbit)
        known = (place, self.steady_inputs, Interval(gain.ravel(order="F")), Interval([step]))
        self._numbers = Interval(
            np.concatenate([each.lower for each in known]),
            np.concatenate([each.upper for each in known]),
        )
        x, values = ca.SX.sym("x", NX), ca.SX.sym("numbers", len(self._numbers.lower))
        x_ss, u_ss, t_s = values[:NX], values[NX : NX + NU], values[-1]
        k = ca.reshape(values[NX + NU : -1], NU, NX)
        following = error_step(model, scheme, x, k @ x, x_ss, u_ss, t_s)
        self._slopes = ca.Function("slopes", [x, values], [following, ca.jacobian(following, x)])
        bends = ca.vertcat(*(ca.hessian(following[i], x)[0] for i in _RANGE))
        self._bends = ca.Function("bends", [x, values], [ca.cse(bends)])

    def value_and_jacobian(self, x: Interval) -> tuple[Interval, Interval]:
        """Enclosures of f and its Jacobian on the box ``x``."""
        value, jacobian = evaluate(self._slopes, [x, self._numbers])
        return value, jacobian

    def hessians(self, x: Interval) -> Interval:
        """Enclosures of the Hessians of the components of f on boxes, shape (n, 5, 5, 5).

        Args:
            x: The boxes, shape (n, 5).
        """
        (found,) = evaluate(self._bends, [x, self._numbers])
        shape = (-1, NX, NX, NX)
        return Interval(found.lower.reshape(shape), found.upper.reshape(shape))


def steady_intervals(model: str, orbit: Orbit) -> tuple[Interval, Interval]:
    """x_ss and u_ss of an orbit, pi/2 and the drift being enclosed.

    Args:
        model: Name of a relative model.
        orbit: Reference.

    Raises:
        ArithmeticError: The model's rates do not vanish there: no steady state.
    """
    bearing = HALF_TURN * (-0.5 * orbit.sense)
    place = vector([orbit.range, bearing, orbit.altitude, 0.0, orbit.speed])
    for name, vanishes in zip(STATE_NAMES, vanishing_rates(model), strict=True):
        if not vanishes:
            raise ArithmeticError(f"rate of {name} of model {model!r} does not vanish on the orbit")
    (drift,) = evaluate(rates_function(model), [place, Interval(np.zeros(NU))])
    return place, vector([-drift[STATE_NAMES.index("bearing")], 0.0, 0.0])


def stage_weight(
    q: NDArray[np.float64], r: NDArray[np.float64], k: NDArray[np.float64]
) -> Interval:
    """Q + K'RK, enclosed."""
    return product(Interval(k.T), product(Interval(r), Interval(k))) + q


@dataclass(frozen=True)
class Expansion:
    """Taylor's a + J d + e of F on boxes.

    Attributes:
        value: a, with the middle of the remainder.
        jacobian: J.
        error: E^2 [-].
        influence: How much each coordinate's width adds to E, about, shape (n, 5).
    """

    value: Interval
    jacobian: Interval
    error: NDArray[np.float64]
    influence: NDArray[np.float64]

    def in_floats(self) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        """a, J and E^2 near the middle of their enclosures, shapes (n, 5), (n, 5, 5) and (n,)."""
        jacobian = np.broadcast_to(self.jacobian.middle(), (len(self.error), NX, NX))
        return (
            np.nan_to_num(self.value.middle(), posinf=0.0, neginf=0.0),
            np.nan_to_num(jacobian, posinf=0.0, neginf=0.0),
            np.nan_to_num(self.error, nan=1e30, posinf=1e30),
        )


@dataclass(frozen=True)
class Guess:
    """Numbers that make the bound low on boxes, in plain floating point: any will do.

    Attributes:
        young: t, shape (n,) [-].
        convexifier: The diagonal of D, shape (n, 5).
        point: Where the tangent plane touches, shape (n, 5).
        excess: The left side minus the right one there, about, shape (n,) [-].
        height: x'Px there, shape (n,) [-].
        pull: How steep the bound is in F, shape (n,) [-].
    """

    young: NDArray[np.float64]
    convexifier: NDArray[np.float64]
    point: NDArray[np.float64]
    excess: NDArray[np.float64]
    height: NDArray[np.float64]
    pull: NDArray[np.float64]


class QuadraticBound:
    """The inequality of the module's docstring, box by box.

    Args:
        loop: f(x, Kx).
        p: P, symmetric positive definite, shape (5, 5).
        right: N.
        level: varrho [-].
        subtracted: C, shape (5, 5), or None for 0.

    Raises:
        ValueError: P is not symmetric to the last bit, or the level not positive and finite.
    """

    def __init__(
        self,
        loop: ClosedLoop,
        p: NDArray[np.float64],
        right: Interval,
        level: float,
        subtracted: NDArray[np.float64] | None = None,
    ) -> None:
        if not np.array_equal(p, p.T):  # tests take the gradient of x'Px as 2Px
            raise ValueError("P must be symmetric to the last bit")
        if not np.isfinite(level) or level <= 0.0:
            raise ValueError(f"level is {level}, must be positive and finite")
        self._loop, self._p, self._right, self.level = loop, p, right, level
        self._subtracted = None if subtracted is None else Interval(subtracted)

    def _value_and_jacobian(self, x: Interval) -> tuple[Interval, Interval]:
        """Enclosures of F and its Jacobian on the box ``x``."""
        value, jacobian = self._loop.value_and_jacobian(x)
        if self._subtracted is None:
            return value, jacobian
        return value - times(self._subtracted, x), jacobian - self._subtracted

    def root(self) -> NDArray[np.float64]:
        """Half-widths e of a box [-e, e] that holds X_f: e_i^2 >= varrho (P^-1)_ii, shape (5,).

        They have 24-bit mantissas, so that halving boxes again and again stays exact.
        """
        diagonal = inverse_of(self._p)[np.arange(NX), np.arange(NX)]
        mantissa, exponent = np.frexp((diagonal * self.level).sqrt().upper)
        return np.ldexp(np.ceil(mantissa * 2.0**24) + 1.0, exponent - 24)

    def violated_at(self, state: NDArray[np.float64]) -> bool:
        """Whether a state of X_f surely has the left side above the right.

        Args:
            state: x, shape (5,), taken as exact doubles.
        """
        x, p = Interval(state), Interval(self._p)
        image, _ = self._value_and_jacobian(x)
        left, right = quadratic(p, image), quadratic(self._right, x)
        return bool(left.lower > right.upper and quadratic(p, x).upper <= self.level)

    def holds_at_origin(
        self, center: NDArray[np.float64], half: NDArray[np.float64]
    ) -> NDArray[np.bool_]:
        """Where the inequality is confirmed, shape (n,), on boxes that hold the origin.

        Args:
            center: Middles of the boxes, shape (n, 5).
            half: Their half-widths, shape (n, 5).
        """
        p, box = Interval(self._p), Interval(center) + UNIT * Interval(half)
        _, slope = self._value_and_jacobian(Interval(np.zeros(NX)))
        bends = self._loop.hessians(box).transposed  # symmetric: sums run along the last axis
        whole = slope + total(box[:, None, None, :] * bends) * 0.5
        image = product(whole.transposed, product(p, whole))
        scale = Interval(np.linalg.inv(np.linalg.cholesky(self._p)))
        return definite(product(scale, product(self._right - image, scale.transposed)))

    def expansion(self, center: NDArray[np.float64], half: NDArray[np.float64]) -> Expansion:
        """Taylor's expansion of F on boxes.

        Args:
            center: Middles of the boxes, shape (n, 5).
            half: Their half-widths, shape (n, 5).
        """
        p, c, h = self._p, Interval(center), Interval(half)
        value, jacobian = self._value_and_jacobian(c)
        bends = self._loop.hessians(c + UNIT * h)
        remainder = Interval(np.zeros_like(center))
        for i in _RANGE:
            width = h[:, None, i]
            remainder = remainder + bends[..., i, i] * width.square() * Interval(0.0, 0.5)
            for j in range(i):
                remainder = remainder + bends[..., i, j] * width * h[:, None, j] * UNIT
        middle = Interval(remainder.middle())
        radius = Interval((remainder - middle).magnitude())
        error = quadratic(Interval(np.abs(p)), radius).upper
        size = np.nan_to_num(bends.magnitude() * half[:, None, :, None] * half[:, None, None])
        bent = 0.5 * np.einsum("k,nkij->ni", np.sqrt(np.diag(p)), size)
        influence = 1e-9 * half * np.sqrt(np.diag(p)) + bent
        return Expansion(value + middle, jacobian, error, influence)

    def guess(
        self,
        center: NDArray[np.float64],
        half: NDArray[np.float64],
        expanded: tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]],
        m: NDArray[np.float64],
    ) -> Guess:
        """Numbers t, D and a point of tangency that make the bound low on boxes.

        Args:
            center: Middles of the boxes, shape (n, 5).
            half: Their half-widths, shape (n, 5).
            expanded: a, J and E^2 of :meth:`Expansion.in_floats`.
            m: Multipliers, shape (n,).
        """
        p, (a, jacobian, error) = self._p, expanded
        big = self._right.middle() + m[:, None, None] * p
        pj = p @ jacobian
        squared = np.swapaxes(jacobian, 1, 2) @ pj
        pulled = np.einsum("mki,mk->mi", pj, a)
        point, axes = np.zeros_like(center), np.arange(NX)
        reach = np.sqrt(np.einsum("mi,ij,mj->m", a, p, a))
        for _ in range(3):
            t = np.clip(np.sqrt(error) / np.maximum(reach, 1e-150), 1e-9, 1.0)
            curved = big - (1.0 + t)[:, None, None] * squared
            scaled = curved * half[:, :, None] * half[:, None, :]
            values, vectors = np.linalg.eigh(scaled)
            floor = 1e-7 * np.abs(values[:, -1:])
            lacking = np.where(values <= floor, floor - values, 0.0)
            sizes = np.abs(vectors)
            bend = np.einsum("mk,mik,mk->mi", lacking, sizes, sizes.sum(axis=1))
            short = np.any(lacking > 0.0, axis=1, keepdims=True)
            bend = np.where(short, 1.001 * bend + floor, 0.0) / half**2
            curved[:, axes, axes] += bend
            linear = (1.0 + t)[:, None] * pulled - np.einsum("mij,mj->mi", big, center)
            point = _highest(curved, linear, half, point)
            image = a + np.einsum("mij,mj->mi", jacobian, point)
            reach = np.sqrt(np.einsum("mi,ij,mj->m", image, p, image))
        x = center + point
        height = np.einsum("mi,ij,mj->m", x, p, x)
        excess = (
            (1.0 + t) * reach**2
            + (1.0 + 1.0 / t) * error
            - np.einsum("mi,mij,mj->m", x, big, x)
            + m * self.level
            + np.einsum("mi,mi->m", bend, half**2 - point**2)
        )
        return Guess(t, bend, point, excess, height, reach)

    def confirmed(
        self,
        center: NDArray[np.float64],
        half: NDArray[np.float64],
        m: NDArray[np.float64],
        expansion: Expansion,
        guess: Guess,
    ) -> NDArray[np.bool_]:
        """Where the inequality is confirmed, shape (n,), on boxes away from the origin.

        Args:
            center: Middles of the boxes, shape (n, 5).
            half: Their half-widths, shape (n, 5).
            m: Their multipliers, shape (n,).
            expansion: On these boxes.
            guess: For these boxes.
        """
        p, times_m, t = Interval(self._p), Interval(m), Interval(guess.young)
        c, h, young = Interval(center), Interval(half), t + 1.0
        d, diagonal = Interval(guess.point), Interval(guess.convexifier)
        value, jacobian = expansion.value, expansion.jacobian
        big = self._right + p * times_m[:, None, None]
        squared = product(jacobian.transposed, product(p, jacobian))
        curved = with_diagonal(big - squared * young[:, None, None], diagonal)
        concave = definite(curved * h[:, :, None] * h[:, None, :])
        x, image = c + d, value + times(jacobian, d)
        p_image, big_x = times(p, image), times(big, x)
        top = dot(image, p_image) * young
        top = top + Interval(expansion.error) * (t.inverse() + 1.0) + times_m * self.level
        top = top - dot(x, big_x)
        slope = times(jacobian.transposed, p_image) * young[:, None] - big_x - diagonal * d
        convexified, tilted = diagonal * (h.square() - d.square()), 2.0 * slope * (UNIT * h - d)
        for i in _RANGE:
            top = top + convexified[:, i] + tilted[:, i]
        return concave & (top.upper <= 0.0)


def decrease_bound(
    loop: ClosedLoop,
    p: NDArray[np.float64],
    q: NDArray[np.float64],
    r: NDArray[np.float64],
    k: NDArray[np.float64],
    slack: float,
    level: float,
) -> QuadraticBound:
    """V_f(f(x, Kx)) - V_f(x) + L(x, Kx) <= -slack V_f(x), P, Q, R and K taken as exact."""
    right = Interval(p) * (Interval(1.0) - slack) - stage_weight(q, r, k)
    return QuadraticBound(loop, p, right, level)


def _highest(
    curved: NDArray[np.float64],
    linear: NDArray[np.float64],
    half: NDArray[np.float64],
    point: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Maximise 2 l'd - d'Sd over |d_i| <= h_i: coordinate ascent, Newton steps among the free."""
    point, eye = point.copy(), np.eye(NX)
    for _ in range(8):
        free = np.abs(point) < half
        system = np.where(free[:, :, None] & free[:, None, :], curved, eye)
        fixed = linear - np.einsum("mij,mj->mi", curved, np.where(free, 0.0, point))
        step = np.linalg.solve(system, np.where(free, fixed, point)[..., None])[..., 0]
        point = np.clip(step, -half, half)
        slope = linear - np.einsum("mij,mj->mi", curved, point)
        outward = np.where(np.abs(point) < half, 0.0, slope * np.sign(point))
        if np.all(np.abs(step) <= half) and np.all(outward >= 0.0):
            break
        for _ in range(2):
            for i in _RANGE:
                rest = linear[:, i] - np.einsum("mj,mj->m", curved[:, i], point)
                best = point[:, i] + rest / curved[:, i, i]
                point[:, i] = np.clip(best, -half[:, i], half[:, i])
    return point
