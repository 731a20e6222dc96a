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

"""The guidance that the parameters ask for: an optimal control problem to solve, or a law."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.control.bank_alone import BankAlone
from uav_tracking_mpc.dynamics.orbit import Orbit
from uav_tracking_mpc.dynamics.symbolic_work import one_at_a_time
from uav_tracking_mpc.estimation.navigator import Estimate
from uav_tracking_mpc.estimation.situation import Situation
from uav_tracking_mpc.formulation.formulation import Formulation, Plan, SolverMaker, solver_of
from uav_tracking_mpc.laws import GuidanceLaw
from uav_tracking_mpc.parameters.registry import GUIDANCE_LAW, ExtensionError
from uav_tracking_mpc.parameters.specification import ParameterError
from uav_tracking_mpc.settings.tracking import ARTIFICIAL_ORBIT, PREDICTIVE, TrackingParameters


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

    return PaperFormulation(parameters, make_solver=make_solver)


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
    """
    found, model = law(orbit, parameters.envelope), parameters.vehicle
    return found if model.commanded == 3 else BankAlone(found, model)


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


def planned(
    formulation: Formulation, estimate: Estimate, orbit: Orbit, elapsed: float | None
) -> tuple[Plan | None, str]:
    """Plan of a formulation that may fail.

    Args:
        formulation: Of the optimal control problem.
        estimate: What the plan is made from.
        orbit: What is wanted.
        elapsed: See :meth:`Formulation.solve`, in [s].

    Returns:
        A finite plan, or None; and why there is none, in words.
    """
    try:
        plan = formulation.solve(estimate.effect, estimate.forecast, orbit, elapsed)
    except (ArithmeticError, RuntimeError, ValueError) as error:
        return None, f"the controller failed: {error}"
    if not np.all(np.isfinite(plan.inputs)):
        return None, f"the plan is not finite: {plan.solution.message}"
    return plan, ""
