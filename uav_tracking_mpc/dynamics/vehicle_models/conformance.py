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

"""Whether a model of the vehicle keeps what :class:`VehicleModel` asks for."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.dynamics.orbit import OrbitMotion
from uav_tracking_mpc.dynamics.vehicle import air_velocity
from uav_tracking_mpc.dynamics.vehicle_models import (
    Drift,
    VehicleModel,
    VehicleState,
    step_function,
)
from uav_tracking_mpc.parameters.conformance import judged, require, require_name, require_vector

COUNT = 50  # random states
INSTANT = 1e-3  # s, of the step whose slope is compared with the kinematics
SETTLING, TURN = 60, 0.2  # s, rad/s: of a turn that is kept, and its rate


def check_model(model: type[VehicleModel]) -> None:
    """Step a model with its default parameters from random states, in numbers and in symbols.

    Args:
        model: Class of the model.

    Raises:
        ConformanceError: It raises, its state does not begin with that of the base, a step is not
            finite, differs between numbers and symbols or is not that of an aircraft, the turn does
            not follow its command, or an orbit is not settled.
    """
    name = require_name(model)
    begins = tuple(getattr(model.State, "_fields", ()))[: len(VehicleState._fields)]
    wanted = VehicleState._fields
    require(begins == wanted, f"{name}: State begins with {begins}, must begin with {wanted}")
    with judged(name):
        made = model()
        require_vector(made.lags, 1e3, f"{name}: lags")
        require(np.all(np.asarray(made.lags) >= 0.0), f"{name}: a lag is negative")
        random = np.random.default_rng(0)
        for _ in range(COUNT):
            _check_step(made, random)
        _check_turn(made)


def _check_step(model: VehicleModel, random: np.random.Generator) -> None:
    target, place = random.uniform(-100.0, 100.0, (2, 3))
    heading, path_angle = random.uniform(-math.pi, math.pi), random.uniform(-0.5, 0.5)
    velocity, slope = random.uniform(-1.0, 1.0, (2, 3)) * [[10.0], [0.2]]
    rates, inputs = random.uniform(-0.4, 0.4, (2, 3))
    airspeed = random.uniform(14.0, 32.0)
    begin = model.initial([*(target + place), heading, path_angle, airspeed], target, rates)
    known = [*place, heading, path_angle, airspeed, *rates]
    require(
        np.allclose(np.array(begin[:9], dtype=float), known),
        f"{model.name}: initial() of a state with {known} is {begin}",
    )
    drift, duration = Drift(velocity, slope), random.uniform(0.05, 1.0)
    for time in (INSTANT, duration):
        numbers = np.asarray(model.numbers(time), dtype=float)
        after = np.array(model.step(begin, inputs, time, numbers, drift), dtype=float)
        require(
            np.all(np.isfinite(after)),
            f"{model.name}: {time:g} s after {begin} is {after.tolist()}",
        )
        told = [list(begin), inputs, numbers, velocity, slope, time]
        symbolic = np.array(step_function(model)(*told)).ravel()
        require(
            np.allclose(after, symbolic, rtol=1e-9, atol=1e-9),
            f"{model.name}: {time:g} s after {begin} is {after.tolist()} in numbers, "
            f"{symbolic.tolist()} in symbols",
        )
        if time == INSTANT:
            slopes = (after[:6] - np.array(begin[:6], dtype=float)) / time
            _check_slopes(
                model,
                slopes,
                np.array(air_velocity(heading, path_angle, airspeed, np)) + velocity,
                np.sort([rates, inputs], axis=0),
            )


def _check_slopes(
    model: VehicleModel,
    slopes: NDArray[np.float64],
    velocity: NDArray[np.float64],
    span: NDArray[np.float64],
) -> None:
    """The position moves with the air velocity and the drift, angles and airspeed with rates."""
    require(
        np.allclose(slopes[:3], velocity, atol=0.1),
        f"{model.name}: the position moves with {slopes[:3]} m/s, must with {velocity}",
    )
    require(
        np.all((slopes[3:] >= span[0] - 0.01) & (slopes[3:] <= span[1] + 0.01)),
        f"{model.name}: (psi', chi', v') are {slopes[3:]}, must be between rates and commands, "
        f"{span.tolist()}",
    )


def _check_turn(model: VehicleModel) -> None:
    still, speed = Drift([0.0] * 3, [0.0] * 3), 22.0
    state = model.initial([0.0, 0.0, 100.0, 0.0, 0.0, speed], [0.0] * 3, [0.0] * 3)
    numbers = model.numbers(1.0)
    for _ in range(SETTLING):
        state = model.step(state, (TURN, 0.0, 0.0), 1.0, numbers, still)
    turn = float(state.turn_rate)
    words = f"{model.name}: {SETTLING} s after a command of {TURN} rad/s it turns with {turn:.4g}"
    require(abs(turn - TURN) < 0.05 * TURN, words)
    radius = speed / TURN
    vehicle = [radius, 0.0, 100.0, math.pi / 2.0, 0.0, speed]
    orbit = OrbitMotion((0.0, 1.0), speed, TURN, 0.0, 0.0)  # type: ignore[arg-type]
    left = model.settled(model.initial(vehicle, [0.0] * 3, [TURN, 0.0, 0.0]), orbit)
    require(
        np.allclose(np.array(left, dtype=float), 0.0, atol=1e-9),
        f"{model.name}: settled() on an orbit is {left}, must be all 0",
    )
