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

"""The small aircraft of the configuration of that name: its parameters, its problem, situations."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from uav_tracking_mpc.dynamics.vehicle import advance
from uav_tracking_mpc.estimation.situation import Situation
from uav_tracking_mpc.formulation.flight_formulation import flight_problem
from uav_tracking_mpc.mpc.newton_solver import NewtonSolver
from uav_tracking_mpc.settings.configuration import load_configuration
from uav_tracking_mpc.settings.tracking import TrackingParameters

# Slow machines are not what is tested; nor is any budget above but that of the aircraft.
PATIENT = "nmpc_controller.solve_time_max=5.0"


def parameters(*overrides: str) -> TrackingParameters:
    """Of the controller, as ``NAME=VALUE``; solves may take their time."""
    sections = [f"nmpc_controller.{override}" for override in overrides]
    return load_configuration("small_uav", [PATIENT, *sections]).controller


@lru_cache
def flight():
    """The flight problem with the configuration's horizon; the only one that is compiled."""
    return flight_problem(parameters())


def problem():
    """The same, as a solver takes it."""
    return flight().problem


@lru_cache
def shared_solver() -> NewtonSolver:
    """One compiled solver for every test of a file; reset it first."""
    return NewtonSolver(problem())


def solver() -> NewtonSolver:
    """The shared one, as new."""
    shared_solver().reset()
    shared_solver().time_limit = float("inf")
    return shared_solver()


def situation(
    x=400.0,
    y=0.0,
    z=120.0,
    heading=np.pi,
    path_angle=0.0,
    airspeed=22.0,
    *,
    target=(0.0, 0.0, 0.0),
    drift=(0.0, 0.0, 0.0),
    drift_rate=(0.0, 0.0, 0.0),
    rates=(0.0, 0.0, 0.0),
) -> Situation:
    """Aircraft at an offset (x, y, z) from its target."""
    target = np.array(target, dtype=float)
    vehicle = np.array([*(np.array([x, y, z]) + target), heading, path_angle, airspeed])
    return Situation(
        vehicle,
        target,
        np.array(drift, dtype=float),
        np.array(drift_rate, dtype=float),
        np.array(rates, dtype=float),
    )


def on_orbit(flown: TrackingParameters, azimuth: float, sense: float) -> Situation:
    """On the wanted orbit without drift, turning as it does."""
    orbit = flown.orbit
    turn = sense * orbit.speed / orbit.radius
    return situation(
        orbit.radius * np.cos(azimuth),
        orbit.radius * np.sin(azimuth),
        orbit.altitude,
        azimuth + sense * np.pi / 2.0,
        airspeed=orbit.speed,
        rates=(turn, 0.0, 0.0),
    )


def random_situations(count: int, seed: int) -> list[Situation]:
    """Flyable ones: inside airspeed and path-angle limits, above the floor, drift below 12 m/s."""
    flown, rng = parameters(), np.random.default_rng(seed)
    situations = []
    for _ in range(count):
        distance, azimuth = rng.uniform(80.0, 900.0), rng.uniform(-np.pi, np.pi)
        airspeed = rng.uniform(16.0, 30.0)
        turn = 0.9 * flown.envelope.turn_rate_max(airspeed)
        towards, strength = rng.uniform(-np.pi, np.pi), rng.uniform(0.0, 12.0)
        situations.append(
            situation(
                distance * np.cos(azimuth),
                distance * np.sin(azimuth),
                rng.uniform(70.0, 180.0),
                rng.uniform(-np.pi, np.pi),
                rng.uniform(-0.1, 0.15),
                airspeed,
                drift=(strength * np.cos(towards), strength * np.sin(towards), 0.0),
                rates=(rng.uniform(-turn, turn), rng.uniform(-0.1, 0.1), rng.uniform(-0.5, 0.5)),
            )
        )
    return situations


STEP = 0.05
SMALL_UAV = parameters().envelope


def fly(law, start, duration, wind=(0.0, 0.0, 0.0), target_velocity=(0.0, 0.0, 0.0)):
    """Offsets from the target (n, 3), vehicle states (n, 6) and inputs (n, 3)."""
    vehicle, target = np.array(start, dtype=float), np.zeros(3)
    wind, run, rates = np.array(wind), np.array(target_velocity), np.zeros(3)
    offsets, vehicles, inputs = [], [], []
    for _ in range(round(duration / STEP)):
        situation = Situation(vehicle, target, wind - run, np.zeros(3), rates)
        rates = law.inputs(situation)
        offsets.append(situation.offset)
        vehicles.append(vehicle)
        inputs.append(rates)
        vehicle = advance(vehicle, rates, STEP)
        vehicle[:3] += STEP * wind
        target = target + STEP * run
    return np.array(offsets), np.array(vehicles), np.array(inputs)


def range_errors(law, offsets):
    return np.linalg.norm(offsets, axis=1) - law.orbit.range
