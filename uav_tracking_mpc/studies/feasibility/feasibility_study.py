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

"""What is guaranteed of a problem with an artificial orbit, beside a campaign that shows it."""

from __future__ import annotations

from typing import Any

from uav_tracking_mpc.settings.configuration import Configuration
from uav_tracking_mpc.settings.tracking import ARTIFICIAL_ORBIT
from uav_tracking_mpc.studies.feasibility.feasibility_campaign import campaign, summary
from uav_tracking_mpc.studies.feasibility.guarantee import (
    GUARANTEED,
    NOT_GUARANTEED,
    PREMISE,
    as_words,
)
from uav_tracking_mpc.studies.feasibility.random_flights import random_situations


def feasibility_study(
    configuration: Configuration, count: int = 0, workers: int | None = None
) -> dict[str, Any]:
    """Say what is guaranteed and fly random states.

    Args:
        configuration: With the terminal constraint ``artificial_orbit``.
        count: Random states to fly; 0 for none.
        workers: Processes; all cores by default.

    Returns:
        Plain values: ``config``, ``terminal_constraint``, ``premise``, ``guaranteed``,
        ``not_guaranteed``; with a campaign also ``clean`` (nothing happened that is guaranteed not
        to) and what :func:`~uav_tracking_mpc.studies.feasibility.feasibility_campaign.summary`
        returns.
    """
    content: dict[str, Any] = {
        "config": configuration.name,
        "terminal_constraint": ARTIFICIAL_ORBIT,
        "premise": PREMISE,
        "guaranteed": list(GUARANTEED),
        "not_guaranteed": list(NOT_GUARANTEED),
    }
    if count:
        situations = random_situations(configuration.controller, count)
        content |= summary(campaign(configuration.controller, situations, workers=workers))
        content["clean"] = _clean(content["without_drift"])
    return content


def _clean(counts: dict[str, Any]) -> bool:
    """Whether nothing happened that is guaranteed not to; it takes a first plan."""
    begun = counts["steps"] - counts["cold_failures"]
    return bool(counts["feasible"] >= begun and counts["cost_rises"] == 0)


def in_words(content: dict[str, Any]) -> list[str]:
    """The study for people.

    Args:
        content: What :func:`feasibility_study` returned.
    """
    lines = [as_words()]
    if "clean" not in content:
        return lines
    lines.append("")
    for title, counts in (
        ("all flights", content),
        ("those without drift", content["without_drift"]),
    ):
        lines.append(
            f"{title}: {counts['states']} states, {counts['cold_failures']} of them without a "
            f"first plan; {counts['steps']} solves, {counts['converged']} converged, "
            f"{counts['feasible']} feasible; the cost rose {counts['cost_rises']} times, at most "
            f"by {counts['worst_rise']:.3g}"
        )
    for name in ("cold", "warm"):
        times = content[f"{name}_us"]
        if times["median"] is not None:
            lines.append(
                f"{name}: median {times['median']:.0f} us, 99 % below {times['p99']:.0f} us"
            )
    return lines
