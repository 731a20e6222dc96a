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

"""Whether a guidance law keeps what :class:`GuidanceLaw` asks for."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.dynamics.orbit import DIRECTIONS
from uav_tracking_mpc.dynamics.vehicle import advance
from uav_tracking_mpc.estimation.situation import Situation
from uav_tracking_mpc.laws import GuidanceLaw
from uav_tracking_mpc.parameters.conformance import (
    ConformanceError,
    judged,
    require,
    require_name,
    require_vector,
)
from uav_tracking_mpc.settings.configuration import load_configuration
from uav_tracking_mpc.settings.tracking import TrackingParameters

COUNT = 200  # random situations
LARGEST = 1e3  # rad/s or m/s^2: no input is beyond it
TICK, DURATION = 0.1, 120.0  # s of the flight towards the target


def check_law(law: type[GuidanceLaw]) -> None:
    """Ask a law in random situations of ``small_uav``, some of them extreme, and fly by it.

    Args:
        law: Class of the law.

    Raises:
        ConformanceError: It raises, does not answer three finite inputs inside the envelope,
            changes what it is given, does not answer the same again, leads away from the target,
            or round it in the wrong direction.
    """
    name, parameters = require_name(law), load_configuration("small_uav").controller
    with judged(name):
        _check(law, name, parameters)


def _check(law: type[GuidanceLaw], name: str, parameters: TrackingParameters) -> None:
    orbit, envelope = parameters.orbit, parameters.envelope
    asked, again, random = law(orbit, envelope), law(orbit, envelope), np.random.default_rng(0)
    for case in range(COUNT):
        situation = _situation(random)
        x, y, z = situation.offset.tolist()
        words = f"{name}: case {case}, {x:.4g} m East, {y:.4g} m North, {z:.4g} m above the target"
        kept = {part: value.copy() for part, value in vars(situation).items()}
        inputs = _answer(asked, situation, words)
        same = all(np.array_equal(vars(situation)[part], value) for part, value in kept.items())
        require(same, f"{words}: the law has changed the situation that it was given")
        turn_max, climb_max = envelope.turn_rate_max(situation.airspeed), parameters.pitch_rate_max
        lower = [-turn_max, -climb_max, parameters.acceleration_min]
        upper = [turn_max, climb_max, parameters.acceleration_max]
        require(
            np.allclose(inputs, np.clip(inputs, lower, upper), rtol=0.0, atol=1e-9),
            f"{words}: {inputs.tolist()} is outside the envelope; see Envelope.clip",
        )
        require(
            np.array_equal(inputs, _answer(again, situation, words)),
            f"{words}: another law of the same orbit answers differently",
        )
    for direction in DIRECTIONS:
        _check_approach(law(replace(orbit, direction=direction), envelope), 2.0 * orbit.range)


def _situation(random: np.random.Generator) -> Situation:
    """About a target anywhere, also straight above it, far away, and in a gale."""
    target = random.uniform(-100.0, 100.0, 3)
    level = random.choice([0.0, 1.0, 300.0, 1e4]) * random.uniform(-1.0, 1.0, 2)
    offset = [*level, random.uniform(-50.0, 300.0)]
    heading, path_angle = random.uniform(-np.pi, np.pi), random.uniform(-0.5, 0.5)
    vehicle = np.array([*(target + offset), heading, path_angle, random.uniform(14.0, 32.0)])
    drift, drift_rate, rates = random.uniform(-1.0, 1.0, (3, 3)) * [[25.0], [1.0], [0.4]]
    return Situation(vehicle, target, drift, drift_rate, rates)


def _answer(law: GuidanceLaw, situation: Situation, words: str) -> NDArray[np.float64]:
    try:
        inputs = law.inputs(situation)
    except Exception as error:  # whatever it raises is what its author wants to know
        raise ConformanceError(f"{words}: {type(error).__name__}: {error}") from error
    require_vector(inputs, LARGEST, f"{words}: (u_psi, u_chi, u_v)")
    return np.asarray(inputs, dtype=float)


def _check_approach(law: GuidanceLaw, start: float) -> None:
    """Fly the exact vehicle without lag towards a target that stands in still air."""
    still, state = np.zeros(3), np.array([start, 0.0, law.orbit.altitude, 1.0, 0.0, 22.0])
    for tick in range(round(DURATION / TICK)):
        situation = Situation(state, still, still, still, still)
        words = f"{law.name}: at {tick * TICK:g} s of a flight from {start:g} m"
        state = advance(state, _answer(law, situation, words), TICK)
    distance = float(np.linalg.norm(state[:3]))
    require(
        distance < start,
        f"{law.name}: {DURATION:g} s after {start:g} m it is {distance:.0f} m from the target: do "
        "its signs agree with psi counter-clockwise and chi up?",
    )
    east, north, _ = situation.relative_velocity
    turns = law.orbit.bearing * (state[1] * east - state[0] * north)  # bearing > 0 is clockwise
    words = f"{law.name}: {DURATION:g} s after {start:g} m it does not circle {law.orbit.direction}"
    require(turns > 0.0, f"{words}: does it heed `self.sense`?")
