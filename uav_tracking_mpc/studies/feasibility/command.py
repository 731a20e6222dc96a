"""``uav_tracking stability`` for a configuration whose problem has an artificial orbit.

With ``--json`` one JSON object goes to stdout and nothing else; progress goes to stderr. Exit code
0, or 1 if a campaign saw what is guaranteed not to happen.
"""

from __future__ import annotations

import argparse
import json
from typing import Any

from uav_tracking_mpc.parameters.specification import ParameterError
from uav_tracking_mpc.report.atomic_write import write_atomically
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


def run(arguments: argparse.Namespace, configuration: Configuration) -> int:
    """Say what is guaranteed and, with ``--campaign``, fly random states.

    Args:
        arguments: Of ``uav_tracking stability``, as parsed.
        configuration: With the terminal constraint ``artificial_orbit``.

    Returns:
        Exit code.

    Raises:
        ParameterError: Something of the ellipsoid is asked for.
    """
    for option in ("design", "maps", "figures"):
        if getattr(arguments, option):
            raise ParameterError(
                f"--{option} is about the ellipsoid of the paper's terminal set; configuration "
                f"'{configuration.name}' has terminal_constraint '{ARTIFICIAL_ORBIT}' and none"
            )
    content: dict[str, Any] = {
        "config": configuration.name,
        "terminal_constraint": ARTIFICIAL_ORBIT,
        "premise": PREMISE,
        "guaranteed": list(GUARANTEED),
        "not_guaranteed": list(NOT_GUARANTEED),
    }
    clean = True
    if arguments.campaign:
        situations = random_situations(configuration.controller, arguments.campaign)
        flights = campaign(configuration.controller, situations, workers=arguments.jobs)
        content |= summary(flights)
        clean = _clean(content["without_drift"])
    if arguments.output is not None:
        arguments.output.mkdir(parents=True, exist_ok=True)
        text = json.dumps(content, indent=1, allow_nan=False) + "\n"
        write_atomically(arguments.output / "stability.json", text.encode())
    if arguments.json:
        print(json.dumps(content, indent=1, allow_nan=False))
        return 0 if clean else 1
    print(as_words())
    if arguments.campaign:
        print(f"\n{_campaign_words(content)}")
    return 0 if clean else 1


def _clean(counts: dict[str, Any]) -> bool:
    """Whether nothing happened that is guaranteed not to; it takes a first plan."""
    begun = counts["steps"] - counts["cold_failures"]
    return counts["feasible"] >= begun and counts["cost_rises"] == 0


def _campaign_words(content: dict[str, Any]) -> str:
    lines = []
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
    return "\n".join(lines)
