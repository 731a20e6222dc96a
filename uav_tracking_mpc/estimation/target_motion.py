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

r"""How a target moves: at random, as it is tracked, and on a turn, as it is predicted.

R. A. Singer, "Estimating Optimal Tracking Filter Performance for Manned Maneuvering Targets",
IEEE Trans. Aerospace and Electronic Systems 6(4), 1970: on each axis p' = v, v' = a and

.. math:: a' = -a / \tau + w, \quad E[w(t) w(s)] = (2 \sigma_a^2 / \tau)\, \delta(t - s)

so that the acceleration has standard deviation sigma_a and is forgotten after tau.

A prediction goes on turning: constant turn rate, fading change of speed. With the horizontal
velocity as a complex number, u its direction, omega the turn rate and a_t the acceleration along u,

.. math:: v(t) = u e^{i \omega t} (s + a_t \tau_v (1 - e^{-t/\tau_v}))

which is integrated in closed form. a_t is weighted by how far it exceeds its uncertainty, and never
reverses the target. The vertical velocity is held.

Errors 5 and 10 s ahead, compared with those of a held velocity: on circles a quarter without noise
at 10 Hz, and a few percent less with 3 m of noise at 5 Hz; on noisy straight runs 2 to 6 % more; in
stop and go the same. Those of Singer's own model lie between without noise and are the largest with
it.
"""

from __future__ import annotations

import math

import casadi as ca
import numpy as np
from numpy.typing import NDArray

MANOEUVRE_TIME = 5.0  # s, tau: least prediction errors on circles, straight runs, stop and go
# s without a position after which the velocity fades; of a target that has run straight on
BRIDGE_TIME, STRAIGHT_TIME = 5.0, 30.0
FADE_TIME = 10.0  # s, its time constant
TERMS = 16  # of the series of exp(-x), x <= 1/2: exact to rounding
TURN_RATE_MAX = 1.0  # rad/s
SPEED_TIME = 2.0  # s, tau_v: vehicles change their speed for a few seconds
REWIND = 1.0  # s before the newest position for which a track tells where the target was
STRAIGHT = 1e-7  # rad/s: a slower turn cannot be told from a straight line


def _noise_series() -> NDArray[np.float64]:
    """Coefficients of the entries of Q in powers of x = t / tau, shape (3, 3, n).

    Q is the integral of 2 g g', g = (e^-x - 1 + x, 1 - e^-x, e^-x) being the response to an
    impulse of w. Its closed form cancels to nothing for short times, the series does not.
    """
    decay = np.cumprod(np.append(1.0, -1.0 / np.arange(1, TERMS)))
    position, velocity = decay.copy(), -decay
    position[:2] = velocity[0] = 0.0
    responses = [np.polynomial.Polynomial(series) for series in (position, velocity, decay)]
    products = [2.0 * (one * other).integ() for one in responses for other in responses]
    series = np.array([product.coef[:TERMS] for product in products]).reshape(3, 3, TERMS)
    orders = np.array([2.0, 1.0, 0.0])  # of tau in g
    return MANOEUVRE_TIME ** np.add.outer(orders, orders)[:, :, None] * series


_NOISE_SERIES = _noise_series()
_POWERS = np.arange(float(TERMS))


def singer_motion(duration: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Transition matrix and covariance of the noise of unit sigma_a.

    Args:
        duration: At least 0, in [s].

    Returns:
        F and Q, shape (3, 3) each.
    """
    x = duration / MANOEUVRE_TIME
    if x > 0.5:
        half, noise = singer_motion(duration / 2.0)
        return half @ half, half @ noise @ half.T + noise
    gone = -math.expm1(-x)
    transition = np.array(
        [
            [1.0, duration, MANOEUVRE_TIME**2 * (x - gone)],
            [0.0, 1.0, MANOEUVRE_TIME * gone],
            [0.0, 0.0, 1.0 - gone],
        ]
    )
    return transition, _NOISE_SERIES @ x**_POWERS


def bridged(age: float, held: float = BRIDGE_TIME) -> tuple[float, float]:
    """Time travelled at the velocity last known, and the share of it that is left.

    A target that is lost is taken to run on for a while and then to slow down, so that no
    position runs away.

    Args:
        age: Of the newest measurement in [s].
        held: Time for which it is taken to run on in [s].

    Returns:
        Time in [s], and the share, from 0 to 1.
    """
    left = math.exp(-max(age - held, 0.0) / FADE_TIME)
    return min(age, held) + FADE_TIME * (1.0 - left), left


def _turn() -> ca.Function:
    """Position, velocity and acceleration a time ahead of now, shape (9,).

    Of position, velocity, acceleration now, shape (9,), the variance of the acceleration on each
    axis [m^2/s^4], omega [rad/s] and the time [s].
    """
    motion, variance = ca.SX.sym("motion", 9), ca.SX.sym("variance")
    turn_rate, lead = ca.SX.sym("turn_rate"), ca.SX.sym("lead")
    position, velocity, acceleration = motion[:3], motion[3:6], motion[6:]
    speed = ca.sqrt(velocity[0] ** 2 + velocity[1] ** 2)
    u_x = ca.if_else(speed > 0.0, velocity[0] / speed, 1.0)
    u_y = ca.if_else(speed > 0.0, velocity[1] / speed, 0.0)
    rate = ca.fmin(ca.fmax(turn_rate, -TURN_RATE_MAX), TURN_RATE_MAX)
    rate = ca.if_else(rate < 0.0, ca.fmin(rate, -STRAIGHT), ca.fmax(rate, STRAIGHT))
    along = acceleration[0] * u_x + acceleration[1] * u_y
    along *= along * along / (along * along + variance)
    # Speed gained after a long time; braking ends at rest.
    gained = ca.fmax(along * SPEED_TIME, -speed)
    # v = u (lasting e^(turn t) - gained e^(fade t)), turn = i omega and fade = i omega - 1 / tau_v.
    lasting, decay = speed + gained, ca.exp(-lead / SPEED_TIME)
    cosine, sine = ca.cos(rate * lead), ca.sin(rate * lead)
    # Its integral along u and across it; that of the second term is over fade.
    real, imaginary = decay * cosine - 1.0, decay * sine
    size = rate**2 + 1.0 / SPEED_TIME**2
    ahead = lasting * sine / rate - gained * (rate * imaginary - real / SPEED_TIME) / size
    left = lasting * (1.0 - cosine) / rate + gained * (rate * real + imaginary / SPEED_TIME) / size
    level = u_x * ahead - u_y * left, u_y * ahead + u_x * left
    position += ca.vertcat(*level, velocity[2] * lead)
    velocity = ca.jacobian(position, lead)
    after = ca.vertcat(position, velocity, ca.jacobian(velocity, lead))
    return ca.Function("turn", [motion, variance, turn_rate, lead], [ca.densify(after)])


TURN = _turn()
