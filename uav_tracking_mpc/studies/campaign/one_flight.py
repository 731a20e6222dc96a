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

"""One flight of a campaign, from its number to a row of the results."""

from __future__ import annotations

import math
import threading
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.control.guidance import formulation_of
from uav_tracking_mpc.formulation.formulation import Formulation
from uav_tracking_mpc.parameters.specification import ParameterError, refuse_fixed
from uav_tracking_mpc.settings.configuration import Configuration
from uav_tracking_mpc.settings.tracking import TrackingParameters
from uav_tracking_mpc.simulation.closed_loop import simulate
from uav_tracking_mpc.simulation.flight_log import FlightLog
from uav_tracking_mpc.studies.campaign.campaign_file import Campaign
from uav_tracking_mpc.studies.campaign.criteria import RAISED, Criteria
from uav_tracking_mpc.studies.campaign.flight_plan import planned
from uav_tracking_mpc.studies.comparison.law_names import law_label
from uav_tracking_mpc.studies.comparison.measures import measures

Task = tuple[int, str]  # number of a flight, and the law
Row = dict[str, Any]
_of_thread = threading.local()  # a solver has one workspace: threads must not share it
_compiling = threading.Lock()


def fly_batch(campaign: Campaign, tasks: Sequence[Task]) -> list[Row]:
    """Fly some flights, one after the other, on one compiled solver.

    Args:
        campaign: That they belong to.
        tasks: Which flights by which law.

    Returns:
        A row for each.
    """
    return [fly_one(campaign, *task) for task in tasks]


def fly_one(campaign: Campaign, number: int, law: str) -> Row:
    """Fly a flight; one that raises an error has failed by it.

    Args:
        campaign: That it belongs to.
        number: Of the flight.
        law: Name of the law, or ``path.py:Class``.
    """
    flight = planned(campaign, number)
    try:
        configuration = flight.configuration(law)
        formulation = shared_formulation(configuration.controller)
        log = simulate(configuration, formulation=formulation)
        outcome = outcome_of(log, configuration, campaign.failure, campaign.settled_after)
    except Exception as error:  # whatever it is, it is this flight's failure and no other's
        _of_thread.kept = None  # it may be left half changed
        outcome = {"failed": True, "reasons": RAISED, "error": f"{type(error).__name__}: {error}"}
    words = campaign.words
    inputs = {k: str(x) if k in words else float(x) for k, x in flight.values.items()}
    return {
        "flight": number,
        "law": law_label(law),
        "group": flight.group,
        "mistake": flight.error,
        **inputs,
        **outcome,
    }


def outcome_of(
    log: FlightLog, configuration: Configuration, failure: Criteria, settled_after: float | None
) -> Row:
    """What came of a flight.

    Args:
        log: Record of the flight.
        configuration: What was flown.
        failure: What counts as a failure.
        settled_after: Time in [s] from which on statistics count; None for half the flight.
    """
    parameters = configuration.controller
    after = 0.5 * log.duration if settled_after is None else settled_after
    flown, range_error = measures(log, parameters, after), log.error[:, 0]
    reasons = failure.failures(log, range_error, parameters)
    settled = failure.settled_at(log.time, range_error)
    return {
        "failed": bool(reasons),
        "reasons": ",".join(reasons),
        "error": "",
        "settled_s": settled,
        "worst_settled_m": _worst(range_error[log.time >= settled]) if settled else None,
        "range_rms_m": flown.range_rms_m,
        "range_mean_m": flown.range_mean_m,
        "worst_m": flown.worst_m,
        "altitude_rms_m": flown.altitude_rms_m,
        "airspeed_rms_mps": flown.airspeed_rms_mps,
        "bank_rate_rms_dps": flown.bank_rate_rms_dps,
        "envelope_violations": flown.envelope_violations,
        "solves_failed": log.failures,
        "off_plan": log.commands.plan_reused + log.commands.failsafe,
    }


def _worst(error: NDArray[np.float64]) -> float | None:
    worst = float(np.max(np.abs(error)))
    return worst if math.isfinite(worst) else None


def shared_formulation(parameters: TrackingParameters) -> Formulation | None:
    """The formulation that this thread's flights share, if nothing fixed differs; else a new one.

    Args:
        parameters: What is flown.

    Returns:
        None where a guidance law is flown.
    """
    kept: tuple[TrackingParameters, Formulation] | None = getattr(_of_thread, "kept", None)
    if kept is not None:
        before, formulation = kept
        try:
            refuse_fixed(before, parameters)
        except ParameterError:
            pass  # another problem, or a guidance law
        else:
            return formulation
    with _compiling:
        made = formulation_of(parameters)
    if made is not None:
        _of_thread.kept = parameters, made
    return made
