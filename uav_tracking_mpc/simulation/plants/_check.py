"""Whether a plant keeps what :class:`Plant` asks for."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.estimation.measurement import Measurement
from uav_tracking_mpc.parameters.conformance import (
    ConformanceError,
    require,
    require_array,
    require_name,
)
from uav_tracking_mpc.settings.simulator import SimulatorParameters
from uav_tracking_mpc.simulation.plants import Plant

FARTHEST, FASTEST, QUICKEST = 1e7, 1e3, 1e2  # m, m/s, rad/s: no aircraft goes beyond
TICK = 0.05  # s
COUNT = 100  # ticks of the flight that is checked
PLAN = np.array([[0.2, 0.05, 0.5], [-0.1, -0.05, 0.0], [0.1, 0.0, -0.5]])
PARAMETERS = SimulatorParameters(
    initial_position=(400.0, 0.0, 100.0), initial_speed=15.0, speed_max=40.0, seed=1
)


def check_plant(plant: type[Plant], parameters: SimulatorParameters = PARAMETERS) -> None:
    """Fly a plant for five seconds on plans and check what it says.

    Args:
        plant: Class of the plant.
        parameters: With which it is flown.

    Raises:
        ConformanceError: Its name or truth has not the form that the base asks for, its clock
            does not follow, it moves by itself, two of one seed differ, sensors without noise do
            not tell the truth or disturb the flight, or it takes a plan that cannot be flown.
    """
    name = require_name(plant)
    flown, again = plant(parameters), plant(parameters)
    require(
        flown.parameters is parameters and flown.time == 0.0,
        f"{name}: __init__ must call super().__init__",
    )
    before = flown.truth
    flown.advance(0.0)
    require(
        _same(flown.truth, before), f"{name}: advance(0.0) changed the state: no time has passed"
    )
    period = flown.period or TICK
    for tick in range(COUNT):
        if tick % 20 == 0:
            for each in (flown, again):
                each.accept(PLAN, each.time + np.arange(len(PLAN)))
        flown.advance(period)
        try:
            check_measurement(flown.truth, f"{name}: truth at {flown.time:g} s")
        except ValueError as error:
            raise ConformanceError(f"{name}: truth at {flown.time:g} s: {error}") from error
        again.measured()  # looking must not change the flight
        again.advance(period)
        require(
            math.isclose(flown.time, (tick + 1) * period, abs_tol=1e-6),
            f"{name}: time is {flown.time} s after {tick + 1} steps of {period:g} s",
        )
        require(
            math.isclose(flown.truth.stamp, flown.time, abs_tol=1e-9),
            f"{name}: truth bears the stamp {flown.truth.stamp} s at {flown.time} s",
        )
        require(
            _same(flown.truth, again.truth),
            f"{name}: two flights with the seed {parameters.seed} differ at {flown.time:g} s",
        )
    require(
        not np.allclose(flown.truth.position, before.position, atol=1.0),
        f"{name}: has not moved in {flown.time:g} s",
    )
    require(
        _same(flown.measured(), flown.truth), f"{name}: sensors without noise do not tell truth"
    )
    require_array(flown.wind, (3,), FASTEST, f"{name}: wind")
    _check_noise(plant, parameters)
    _check_refusals(plant(parameters))


def check_measurement(measurement: Measurement, words: str) -> None:
    """Check the form of a measurement.

    Args:
        measurement: Of an aircraft.
        words: Which it is.

    Raises:
        ConformanceError: A part has another shape, is not finite or not of a plausible size.
    """
    require_array(measurement.position, (3,), FARTHEST, f"{words}: position [m]")
    require_array(measurement.ground_velocity, (3,), FASTEST, f"{words}: ground_velocity [m/s]")
    require_array(float(measurement.heading), (), math.pi + 1e-9, f"{words}: heading [rad]")
    require_array(float(measurement.path_angle), (), math.pi, f"{words}: path_angle [rad]")
    for rate in ("turn_rate", "path_angle_rate"):
        require_array(float(getattr(measurement, rate)), (), QUICKEST, f"{words}: {rate} [rad/s]")
    if measurement.airspeed is not None:
        require_array(float(measurement.airspeed), (), FASTEST, f"{words}: airspeed [m/s]")


def _check_noise(plant: type[Plant], parameters: SimulatorParameters) -> None:
    noisy = plant(replace(parameters, position_noise=2.0))
    first, second, truth = noisy.measured(), noisy.measured(), noisy.truth
    require(
        not np.array_equal(first.position, truth.position)
        and not np.array_equal(first.position, second.position),
        f"{plant.name}: position_noise has no effect on measured()",
    )


def _check_refusals(plant: Plant) -> None:
    plant.accept(PLAN, plant.time + np.arange(len(PLAN)))
    bad: dict[str, tuple[NDArray[np.float64], NDArray[np.float64]]] = {
        "that is not finite": (np.array([[math.nan, 0.0, 0.0]]), np.array([plant.time])),
        "of the wrong shape": (np.zeros((1, 2)), np.array([plant.time])),
        "that is empty": (np.zeros((0, 3)), np.zeros(0)),
        "from an hour ahead": (np.zeros((1, 3)), np.array([plant.time + 3600.0])),
    }
    for words, (inputs, starts) in bad.items():
        try:
            plant.accept(inputs, starts)
        except ValueError:
            continue
        raise ConformanceError(f"{plant.name}: a plan {words} is taken, must raise ValueError")
    present = plant.plan.inputs(plant.time)
    require(
        present is not None and np.array_equal(present, PLAN[0]),
        f"{plant.name}: a refused plan has replaced the present one",
    )


def _same(one: Measurement, other: Measurement) -> bool:
    return all(np.array_equal(vars(one)[key], vars(other)[key]) for key in vars(one))
