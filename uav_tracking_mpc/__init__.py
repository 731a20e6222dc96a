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

"""Nonlinear model predictive control of a fixed-wing UAV that circles a ground target in 3-D.

Everything a user needs is imported from here. The control step alone, in a loop of one's own:

>>> from uav_tracking_mpc import Controller, Measurement, load_configuration
>>> controller = Controller(load_configuration("small_uav").controller)
>>> controller.see_target(0.0, [0.0, 0.0, 0.0])
True
>>> measurement = Measurement(
...     stamp=0.0, position=[600.0, 0.0, 100.0], ground_velocity=[-22.0, 0.0, 0.0],
...     heading=3.14, path_angle=0.0, airspeed=22.0,
... )
>>> command = controller.step(measurement, now=0.0)
>>> command.inputs.shape[1]  # turn rate, path-angle rate, acceleration: a row for every stage
3

A whole flight in simulation:

>>> from uav_tracking_mpc import simulate
>>> log = simulate(load_configuration("paper", ["mission.duration=30.0"]))
>>> bool(abs(log.error[-1, 0]) < 1.0)  # of the range in [m]
True

What people add derives from one of the bases ``GuidanceLaw``, ``Limit``, ``Plant``,
``TargetMotion``, ``VehicleLink``, ``VehicleModel``, ``RelativeModel`` and ``Fault``.

Equation numbers everywhere are those of "On the Stability of Nonlinear Model Predictive Control for
3D Target Tracking". Units are SI and radians; frames follow REP-103.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

__version__ = "0.3.0"

if TYPE_CHECKING:
    from uav_tracking_mpc.control.command import Command as Command
    from uav_tracking_mpc.control.controller import Controller as Controller
    from uav_tracking_mpc.control.record import replay as replay
    from uav_tracking_mpc.dynamics.orbit import Orbit as Orbit
    from uav_tracking_mpc.dynamics.relative_models import RelativeModel as RelativeModel
    from uav_tracking_mpc.dynamics.vehicle_models import VehicleModel as VehicleModel
    from uav_tracking_mpc.dynamics.vehicle_models import VehicleState as VehicleState
    from uav_tracking_mpc.dynamics.vehicle_models.conformance import check_model as check_model
    from uav_tracking_mpc.estimation.measurement import Axis as Axis
    from uav_tracking_mpc.estimation.measurement import Measurement as Measurement
    from uav_tracking_mpc.estimation.measurement import MeasurementError as MeasurementError
    from uav_tracking_mpc.estimation.measurement import SensorNoise as SensorNoise
    from uav_tracking_mpc.estimation.situation import Situation as Situation
    from uav_tracking_mpc.laws import GuidanceLaw as GuidanceLaw
    from uav_tracking_mpc.laws.conformance import check_law as check_law
    from uav_tracking_mpc.limits import Limit as Limit
    from uav_tracking_mpc.limits.conformance import check_limit as check_limit
    from uav_tracking_mpc.limits.envelope import Envelope as Envelope
    from uav_tracking_mpc.links import VehicleLink as VehicleLink
    from uav_tracking_mpc.links._check import check_link as check_link
    from uav_tracking_mpc.mpc.casadi_solver import CasadiSolver as CasadiSolver
    from uav_tracking_mpc.mpc.newton_solver import NewtonSolver as NewtonSolver
    from uav_tracking_mpc.mpc.problem import OptimalControlProblem as OptimalControlProblem
    from uav_tracking_mpc.parameters.specification import ParameterError as ParameterError
    from uav_tracking_mpc.settings.configuration import Configuration as Configuration
    from uav_tracking_mpc.settings.configuration import load_configuration as load_configuration
    from uav_tracking_mpc.settings.tracking import TrackingParameters as TrackingParameters
    from uav_tracking_mpc.simulation.closed_loop import simulate as simulate
    from uav_tracking_mpc.simulation.flight_log import FlightLog as FlightLog
    from uav_tracking_mpc.simulation.motions import TargetMotion as TargetMotion
    from uav_tracking_mpc.simulation.motions.conformance import check_motion as check_motion
    from uav_tracking_mpc.simulation.plants import Plant as Plant
    from uav_tracking_mpc.simulation.plants.conformance import check_plant as check_plant
    from uav_tracking_mpc.studies.faults.kinds import Fault as Fault
    from uav_tracking_mpc.studies.faults.kinds.conformance import check_fault as check_fault

# Where each name lives. It is imported when it is first asked for: the import of the package alone
# costs next to nothing.
_HOMES = {
    "Axis": "estimation.measurement",
    "CasadiSolver": "mpc.casadi_solver",
    "Command": "control.command",
    "Configuration": "settings.configuration",
    "Controller": "control.controller",
    "Envelope": "limits.envelope",
    "Fault": "studies.faults.kinds",
    "FlightLog": "simulation.flight_log",
    "GuidanceLaw": "laws",
    "Limit": "limits",
    "Measurement": "estimation.measurement",
    "MeasurementError": "estimation.measurement",
    "NewtonSolver": "mpc.newton_solver",
    "OptimalControlProblem": "mpc.problem",
    "Orbit": "dynamics.orbit",
    "ParameterError": "parameters.specification",
    "Plant": "simulation.plants",
    "RelativeModel": "dynamics.relative_models",
    "SensorNoise": "estimation.measurement",
    "Situation": "estimation.situation",
    "TargetMotion": "simulation.motions",
    "TrackingParameters": "settings.tracking",
    "VehicleLink": "links",
    "VehicleModel": "dynamics.vehicle_models",
    "VehicleState": "dynamics.vehicle_models",
    "check_fault": "studies.faults.kinds.conformance",
    "check_law": "laws.conformance",
    "check_limit": "limits.conformance",
    "check_link": "links._check",
    "check_model": "dynamics.vehicle_models.conformance",
    "check_motion": "simulation.motions.conformance",
    "check_plant": "simulation.plants.conformance",
    "load_configuration": "settings.configuration",
    "replay": "control.record",
    "simulate": "simulation.closed_loop",
}

__all__ = ["__version__", *_HOMES]


def __getattr__(name: str) -> Any:
    """Import a name from its home."""
    home = _HOMES.get(name)
    if home is None:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(importlib.import_module(f"{__name__}.{home}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    """All names, loaded or not."""
    return sorted({*globals(), *__all__})
