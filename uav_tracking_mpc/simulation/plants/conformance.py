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

"""Whether a plant keeps what :class:`Plant` asks for."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from uav_tracking_mpc.estimation.measurement import Measurement
from uav_tracking_mpc.parameters.conformance import (
    ConformanceError,
    judged,
    require,
    require_name,
    require_vector,
)
from uav_tracking_mpc.settings.simulator import SimulatorParameters
from uav_tracking_mpc.simulation.plants import Plant

FARTHEST, FASTEST, QUICKEST = 1e7, 1e3, 1e2  # m, m/s, rad/s: no aircraft goes beyond
TICK = 0.05  # s
# rad/s, rad/s, m/s^2
PLAN = np.array([[0.2, 0.05, 0.5], [-0.1, -0.05, 0.0], [0.1, 0.0, -0.5]])
PARAMETERS = SimulatorParameters(
    initial_position=(400.0, 0.0, 100.0), initial_speed=15.0, speed_max=40.0, seed=1
)


def check_plant(plant: type[Plant], parameters: SimulatorParameters = PARAMETERS) -> None:
    """Fly a plant through a hundred ticks on plans and check what it says.

    Args:
        plant: Class of the plant.
        parameters: With which it is flown.

    Raises:
        ConformanceError: It raises, has no name or no truth that could be one, its clock does not
            follow, it does not move, two of one seed differ, its sensors disturb it or know no
            noise, or it takes a plan that cannot be flown.
    """
    name = require_name(plant)
    with judged(name):
        _check(plant, name, parameters)


def _check(plant: type[Plant], name: str, parameters: SimulatorParameters) -> None:
    flown, again = plant(parameters), plant(parameters)
    start, period = flown.truth, flown.period or TICK
    flown.advance(0.0)
    require(_same(flown.truth, start), f"{name}: advance(0.0) changed the state: no time passed")
    for tick in range(1, 101):
        if tick % 20 == 1:
            for each in (flown, again):
                each.accept(PLAN, each.time + np.arange(len(PLAN)))
        flown.advance(period)
        words = f"{name}: truth at {flown.time:g} s"
        try:
            truth = flown.truth
        except ValueError as error:
            raise ConformanceError(f"{words}: {error}") from error
        check_measurement(truth, words)
        again.measured()  # looking must not change the flight
        again.advance(period)
        require(_same(truth, again.truth), f"{words} differs from that of another with its seed")
        require(
            abs(flown.time - tick * period) + abs(truth.stamp - flown.time) < 1e-6,
            f"{words} has the stamp {truth.stamp} s after {tick} steps of {period:g} s",
        )
    moved = np.linalg.norm(flown.truth.position - start.position)
    require(moved > 1.0, f"{name}: has not moved in {flown.time:g} s")
    require(_same(flown.measured(), flown.aboard), f"{name}: without noise, sensors are not true")
    require_vector(flown.wind, FASTEST, f"{name}: wind [m/s]")
    noisy = plant(replace(parameters, position_noise=2.0))
    require(not _same(noisy.measured(), noisy.measured()), f"{name}: measured() knows no noise")
    _check_refusals(noisy)


def check_measurement(measurement: Measurement, words: str) -> None:
    """Check that a measurement can be one of an aircraft, in SI units and radians.

    Args:
        measurement: Of an aircraft.
        words: Which it is.

    Raises:
        ConformanceError: A part is of a size that it cannot have.
    """
    require_vector(measurement.position, FARTHEST, f"{words}: position [m]")
    require_vector(measurement.ground_velocity, FASTEST, f"{words}: ground_velocity [m/s]")
    largest = {"heading": 1.001 * math.pi, "path_angle": 1.001 * math.pi, "airspeed": FASTEST}
    largest |= {"turn_rate": QUICKEST, "path_angle_rate": QUICKEST}
    for part, limit in largest.items():
        value = getattr(measurement, part) or 0.0
        require(abs(value) <= limit, f"{words}: {part} is {value}: are the units right?")


def _check_refusals(plant: Plant) -> None:
    plant.accept(PLAN, plant.time + np.arange(len(PLAN)))
    for words, inputs, ahead in (
        ("that is not finite", math.nan * PLAN[:1], 0.0),
        ("of the wrong shape", PLAN[:1, :2], 0.0),
        ("that is empty", PLAN[:0], 0.0),
        ("from an hour ahead", PLAN[:1], 3600.0),
    ):
        try:
            plant.accept(inputs, plant.time + ahead + np.arange(len(inputs)))
        except ValueError:
            continue
        raise ConformanceError(f"{plant.name}: a plan {words} is taken, must raise ValueError")
    present = plant.plan.inputs(plant.time)
    kept = present is not None and np.array_equal(present, PLAN[0])
    require(kept, f"{plant.name}: a refused plan has replaced the present one")


def _same(one: Measurement, other: Measurement) -> bool:
    return all(np.array_equal(vars(one)[key], vars(other)[key]) for key in vars(one))
