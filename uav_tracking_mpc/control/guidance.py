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

"""The guidance that the parameters ask for: an optimal control problem, or a law."""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.dynamics.orbit import CLOCKWISE, COUNTER_CLOCKWISE, DIRECTIONS, Orbit
from uav_tracking_mpc.dynamics.vehicle_models import VehicleModel
from uav_tracking_mpc.estimation.situation import Situation
from uav_tracking_mpc.formulation.formulation import (
    Formulation,
    SolverMaker,
    solver_as_told,
    solver_of,
)
from uav_tracking_mpc.laws import GUIDANCE_LAW, GuidanceLaw
from uav_tracking_mpc.mpc.compiled_method import Compilation, method_folder
from uav_tracking_mpc.parameters.registry import ExtensionError
from uav_tracking_mpc.parameters.specification import ParameterError
from uav_tracking_mpc.settings.tracking import (
    ARTIFICIAL_ORBIT,
    NEAREST,
    PREDICTIVE,
    TrackingParameters,
)
from uav_tracking_mpc.symbolic.functions import one_at_a_time

# rad. The other direction is the nearer one beyond 90 deg from the tangent. The direction changes
# only when it is nearer by more than 45 deg (hysteresis).
HYSTERESIS = math.radians(45.0)


def nearest_direction(
    situation: Situation, present: str | None = None, stands: bool = False
) -> str:
    """Direction of the orbit to which the relative velocity needs to turn less.

    Args:
        situation: Where the aircraft is and goes.
        present: Direction that is flown, if one is: kept but for a flight clearly against it.
        stands: Whether it is kept in any case.
    """
    if stands and present is not None:
        return present
    x, y, _ = situation.offset.tolist()
    w_x, w_y, _ = situation.relative_velocity.tolist()
    speed_distance = math.hypot(x, y) * math.hypot(w_x, w_y)
    # Cosine of the angle between relative velocity and counter-clockwise tangent.
    along = (x * w_y - y * w_x) / speed_distance if speed_distance > 0.0 else 0.0
    if present is None:
        return COUNTER_CLOCKWISE if along > 0.0 else CLOCKWISE
    follows = along if present == COUNTER_CLOCKWISE else -along
    if not follows < -math.sin(HYSTERESIS):  # also where it is no number
        return present
    return CLOCKWISE if present == COUNTER_CLOCKWISE else COUNTER_CLOCKWISE


class BankAlone(GuidanceLaw):
    """A law, with what the autopilot finds itself in the place of its other inputs.

    Args:
        law: Whose turn rate is flown.
        model: Of the aircraft, which says what the autopilot finds itself.
    """

    def __init__(self, law: GuidanceLaw, model: VehicleModel) -> None:
        super().__init__(law.orbit, law.envelope)
        self.name = law.name  # type: ignore[misc]  # errors are told by the name of the law
        self._law, self._model = law, model
        self._numbers = model.numbers(1.0)  # none of those of what is held depends on the step

    def inputs(self, situation: Situation) -> NDArray[np.float64]:
        """See :meth:`GuidanceLaw.inputs`; the envelope has no say in what the autopilot finds."""
        state = self._model.initial(situation.vehicle, situation.target, situation.rates)
        held = self._model.held(
            state, self.orbit.altitude, self.orbit.speed, self._numbers, situation.drift
        )
        inputs = np.array(self._law.inputs(situation), dtype=float)
        inputs[self._model.commanded :] = held
        return inputs


@one_at_a_time
def formulation_of(
    parameters: TrackingParameters, make_solver: SolverMaker = solver_of
) -> Formulation | None:
    """Formulation that the parameters ask for; only this one is loaded.

    Args:
        parameters: What is flown.
        make_solver: Makes the solver of its problem.

    Returns:
        None where a guidance law is flown.
    """
    if parameters.law != PREDICTIVE:
        return None
    if parameters.terminal_constraint == ARTIFICIAL_ORBIT:
        from uav_tracking_mpc.formulation.flight_formulation import FlightFormulation

        return FlightFormulation(parameters, make_solver=make_solver)
    from uav_tracking_mpc.formulation.paper_formulation import PaperFormulation

    return PaperFormulation(parameters, make_solver)


def law_of(parameters: TrackingParameters) -> type[GuidanceLaw] | None:
    """Class of the law that the parameters ask for.

    Args:
        parameters: What is flown.

    Returns:
        None where the predictive controller is flown.

    Raises:
        ParameterError: There is no such law.
    """
    if parameters.law == PREDICTIVE:
        return None
    try:
        return GUIDANCE_LAW.find(parameters.law)
    except ExtensionError as error:
        raise ParameterError(f"parameter 'law': {error}") from error


def law_about(law: type[GuidanceLaw], orbit: Orbit, parameters: TrackingParameters) -> GuidanceLaw:
    """A law about an orbit; its turn rate alone where the autopilot holds the rest.

    Args:
        law: Its class.
        orbit: What is flown.
        parameters: The envelope, and the model of the aircraft.

    Raises:
        ParameterError: It cannot be made for them.
    """
    try:
        found, model = law(orbit, parameters.envelope), parameters.vehicle
    except Exception as error:  # whatever it raises
        words = f"{type(error).__name__}: {error}"
        raise ParameterError(f"the law {law.name} cannot fly these parameters: {words}") from error
    return found if model.commanded == 3 else BankAlone(found, model)


def ask_law(law: type[GuidanceLaw], parameters: TrackingParameters) -> None:
    """Make sure that a law can be made for the orbit, in either direction if the nearest is flown.

    Args:
        law: Its class.
        parameters: What is asked for.

    Raises:
        ParameterError: It cannot.
    """
    orbit = parameters.orbit
    for direction in DIRECTIONS if parameters.direction == NEAREST else (orbit.direction,):
        law_about(law, dataclasses.replace(orbit, direction=direction), parameters)


def law_inputs(law: GuidanceLaw, situation: Situation) -> tuple[NDArray[np.float64] | None, str]:
    """Inputs of a law that may fail.

    Args:
        law: Anybody's.
        situation: Where the aircraft is and goes.

    Returns:
        (u_psi, u_chi, u_v), shape (1, 3), finite, or None; and why there are none, in words.
    """
    try:
        inputs = np.asarray(law.inputs(situation), dtype=float)
    except Exception as error:  # whatever it raises, the aircraft is not lost over it
        return None, f"the law {law.name} failed: {type(error).__name__}: {error}"
    if inputs.shape != (3,) or not np.isfinite(inputs).all():
        return None, f"the law {law.name} answered {inputs.tolist()}, must be three finite numbers"
    return inputs[np.newaxis], ""


@one_at_a_time
def compiled_into(parameters: TrackingParameters) -> Path | None:
    """Folder of the machine code, whether it is made yet or not.

    Args:
        parameters: What is flown.

    Returns:
        None where nothing is compiled for it.

    Raises:
        ParameterError: It cannot be flown.
        NotImplementedError: The problem uses an operation that cannot be compiled.
    """
    formulation = formulation_of(parameters, solver_as_told(lambda: False))
    if formulation is None or parameters.solver != "newton":
        return None
    return method_folder(formulation.solver.problem)


def compile_flight(parameters: TrackingParameters) -> Path | None:
    """Return when the machine code is there; where it is already, at once.

    Args:
        parameters: What is flown.

    Returns:
        As of :func:`compiled_into`.

    Raises:
        ParameterError: It cannot be flown.
        CompilationError: It cannot be compiled.
    """
    folder = compiled_into(parameters)
    if folder is not None:
        Compilation(folder).wait()
    return folder
