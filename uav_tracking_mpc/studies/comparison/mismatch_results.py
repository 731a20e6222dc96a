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

"""Flights under mismatches as one object: what ``mismatches.json`` holds."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from typing import Any

from uav_tracking_mpc.settings.tracking import PREDICTIVE
from uav_tracking_mpc.studies.comparison.mismatch_targets import asked_of, missed, resolved
from uav_tracking_mpc.studies.comparison.results import Scenario, finite, solves


def mismatches_as_json(mismatches: Sequence[Scenario]) -> dict[str, Any]:
    """The flights as plain values, never NaN.

    Args:
        mismatches: At least one, all of one configuration.

    Returns:
        - ``config``
        - ``mismatches.<mismatch>.<law>``: as
          :class:`~uav_tracking_mpc.studies.comparison.measures.Measures`
        - ``asked.<mismatch>``: at most ``range_rms_m``, ``range_mean_m``, ``bank_rate_rms_dps``,
          ``envelope_violations`` and ``off_plan``, null where that is not asked; ``of_law``, the
          law whose figures range and bank rate are ``range_rms_share`` and ``bank_rate_rms_share``
          of, null where they are absolute; and what the predictive controller ``missed``
        - ``solves.<mismatch>``: of the predictive controller, as
          :func:`~uav_tracking_mpc.studies.comparison.results.solves`
    """
    flown = [each for each in mismatches if PREDICTIVE in each.logs]
    asked = {each.name: _asked(each) for each in flown}
    return dict(
        finite(
            {
                "config": mismatches[0].configuration.name,
                "mismatches": {
                    each.name: {law: dataclasses.asdict(m) for law, m in each.measures.items()}
                    for each in mismatches
                },
                "asked": {name: bounds for name, bounds in asked.items() if bounds},
                "solves": {each.name: solves(each.logs[PREDICTIVE]) for each in flown},
            }
        )
    )


def _asked(mismatch: Scenario) -> dict[str, Any]:
    """Nothing where nothing is asked."""
    asked = asked_of(mismatch.configuration, mismatch.name)
    if asked is None:
        return {}
    bounds = resolved(asked, mismatch.measures)
    return {
        "range_rms_m": _bound(bounds.range_rms),
        "range_mean_m": _bound(bounds.range_mean),
        "bank_rate_rms_dps": _bound(bounds.bank_rate_rms),
        "envelope_violations": 0 if asked.limits else None,
        "off_plan": 0 if asked.optimal else None,
        "of_law": bounds.law or None,
        "range_rms_share": asked.range_rms if asked.relative else None,
        "bank_rate_rms_share": asked.bank_rate_rms if asked.relative else None,
        "missed": missed(asked, mismatch.measures),
    }


def _bound(value: float) -> float | None:
    return value if math.isfinite(value) else None
