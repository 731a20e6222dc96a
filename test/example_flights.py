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

"""Flights for tests: closed forms, the paper's mission flown once, two laws compared."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.dynamics import paper_numbers
from uav_tracking_mpc.dynamics.orbit import COUNTER_CLOCKWISE, Orbit
from uav_tracking_mpc.dynamics.relative import (
    error_dynamics,
    relative_state,
    steady_inputs,
    tracking_error,
    vehicle_state,
)
from uav_tracking_mpc.dynamics.vehicle import advance
from uav_tracking_mpc.formulation.paper_formulation import tracking_problem
from uav_tracking_mpc.mpc.casadi_solver import CasadiSolver
from uav_tracking_mpc.settings.configuration import load_configuration
from uav_tracking_mpc.simulation.closed_loop import simulate
from uav_tracking_mpc.simulation.flight_log import FlightLog
from uav_tracking_mpc.studies.comparison.results import Scenario, prepared
from uav_tracking_mpc.studies.comparison.scenarios import mismatched, settled_after
from uav_tracking_mpc.terminal.ingredients import paper_problem

ORBIT = paper_numbers.ORBIT
INPUT_UPPER = np.array(paper_numbers.INPUT_BOUNDS)
START = np.array(paper_numbers.INITIAL_STATE)
STEPS = 150


def log_of(relative: NDArray[np.float64], orbit: Orbit = ORBIT, step: float = 1.0) -> FlightLog:
    """A flight through the given relative states, (n, 5), about a target at the origin."""
    turn = orbit.bearing / abs(orbit.bearing) * orbit.speed / orbit.radius
    time = step * np.arange(len(relative))
    vehicle = [
        vehicle_state(state, -turn * t, np.zeros(3))
        for state, t in zip(relative, time, strict=True)
    ]
    count = max(len(relative) - 1, 0)
    u_ss = steady_inputs("exact", orbit)
    return FlightLog(
        config="example",
        duration=float(time[-1]) if len(time) else 0.0,
        speed=0.0,
        model="exact",
        plant="vehicle",
        orbit=orbit,
        input_lower=-INPUT_UPPER,
        input_upper=INPUT_UPPER,
        time=time,
        vehicle=np.array(vehicle).reshape(-1, 6),
        target=np.zeros((len(relative), 3)),
        command_time=time[:count],
        inputs=np.tile(u_ss, (count, 1)),
        cost=np.geomspace(100.0, 1e-6, count) if count else np.zeros(0),
        solve_time=np.linspace(400e-6, 600e-6, count),
        solver="fatrop",
    )


def orbiting(count: int = 151, orbit: Orbit = ORBIT, step: float = 1.0, **changes) -> FlightLog:
    """A perfect orbit, with fields of the record changed afterwards."""
    return replace(log_of(np.tile(orbit.steady_state, (count, 1)), orbit, step), **changes)


@cache
def paper_flight(model: str = "exact", plant: str = "euler") -> FlightLog:
    """The mission of Section 6 and Table 1, N = 10, no terminal constraint."""
    dynamics = error_dynamics(model, ORBIT, 1.0)
    u_ss = steady_inputs(model, ORBIT)
    solver = CasadiSolver(tracking_problem(paper_problem(model), level=None))
    relative, azimuth, target = START, 0.0, np.zeros(3)
    vehicles, inputs, solutions = [vehicle_state(START, azimuth, target)], [], []
    for k in range(STEPS):
        solution = solver.solve(tracking_error(relative, ORBIT), elapsed=1.0 if k else None)
        command = solution.inputs[0] + u_ss
        if plant == "euler":
            error = dynamics(tracking_error(relative, ORBIT), solution.inputs[0])
            following = np.array(error).ravel() + ORBIT.steady_state
            azimuth += command[0] - (following[1] - relative[1])  # phi' = psi' - theta'
            vehicles.append(vehicle_state(following, azimuth, target))
        else:
            vehicles.append(advance(vehicles[-1], command, 1.0))
        relative = relative_state(vehicles[-1], target)
        inputs.append(command)
        solutions.append(solution)
    return FlightLog(
        config="paper",
        duration=float(STEPS),
        speed=0.0,
        model=model,
        plant=plant,
        orbit=ORBIT,
        input_lower=-INPUT_UPPER,
        input_upper=INPUT_UPPER,
        time=np.arange(STEPS + 1.0),
        vehicle=np.array(vehicles),
        target=np.zeros((STEPS + 1, 3)),
        command_time=np.arange(float(STEPS)),
        inputs=np.array(inputs),
        cost=np.array([solution.cost for solution in solutions]),
        solve_time=np.array([solution.solve_time for solution in solutions]),
        solver=solver.name,
        failures=sum(not solution.converged for solution in solutions),
    )


def moving_target() -> FlightLog:
    """Several orbits about a target that drives away at 2 m/s."""
    log = orbiting(600, Orbit(300.0, 120.0, 22.0, COUNTER_CLOCKWISE), step=0.5)
    target = np.outer(log.time, [2.0, 1.0, 0.0])
    vehicle = log.vehicle.copy()
    vehicle[:, :3] += target
    return replace(log, vehicle=vehicle, target=target)


def with_holes() -> FlightLog:
    """Samples, costs and a bound that are not finite."""
    log = orbiting(40)
    vehicle, cost = log.vehicle.copy(), log.cost.copy()
    vehicle[3:6] = np.nan
    cost[::2] = np.nan
    upper = np.array([np.inf, 1.0, 1.0])
    return replace(log, vehicle=vehicle, cost=cost, input_upper=upper)


LAWS = ("nmpc", "l1")
KEYS = {  # of a flight in the JSON
    "range_rms_m",
    "range_mean_m",
    "worst_m",
    "settling_s",
    "altitude_rms_m",
    "airspeed_rms_mps",
    "bank_rate_rms_dps",
    "swing_deg",
    "softened",
    "envelope_violations",
    "violations",
    "off_plan",
    *("altitude_min_m", "altitude_max_m", "airspeed_worst_mps", "airspeed_min_mps"),
    *("airspeed_max_mps", "airspeed_departed_s", "sensors"),
}


@cache
def compared(name="gusts", duration=12.0, config="small_uav") -> Scenario:
    """Flights of l1 and, under the name of nmpc, of vector_field."""
    overrides = [f"mission.duration={duration}"]
    configuration = load_configuration(config, overrides, name)
    return flown(name, configuration)


@cache
def mistold(name="lag_2", duration=12.0) -> Scenario:
    """The same under a mismatch."""
    configuration = mismatched("small_uav", name, (f"mission.duration={duration}",))
    return flown(name, configuration, settled_after(configuration))


def flown(name, configuration, after=None) -> Scenario:
    logs = [simulate(prepared(configuration, law)) for law in ("vector_field", "l1")]
    return Scenario(
        name, configuration, {law: [log] for law, log in zip(LAWS, logs, strict=True)}, after
    )
