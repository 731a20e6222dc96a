"""``uav_tracking torture``: fly under faults, print what came of it, save report and figure."""

from __future__ import annotations

import argparse
import itertools
import json
import signal
from pathlib import Path
from typing import Any

from rich.console import Console

from uav_tracking_mpc.launch.launcher import add_configuration_arguments, add_launch_arguments
from uav_tracking_mpc.report.atomic_write import write_atomically
from uav_tracking_mpc.settings.configuration import load_configuration


def add_torture_parser(subparsers: Any) -> argparse.ArgumentParser:
    """Add the command ``torture``; its handler is ``run`` of the namespace.

    Args:
        subparsers: Of the parser of ``uav_tracking``.
    """
    parser = subparsers.add_parser(
        "torture",
        help="inject faults into real nodes and check that nothing breaks",
        description="Fly with real nodes, inject faults from a seeded schedule, check every "
        "message. Or fly for hours without faults (--soak). Exit code 0 if nothing was violated "
        "and no process was lost.",
    )
    add_configuration_arguments(parser, "small_uav")
    add_launch_arguments(parser)
    parser.add_argument(
        "--minutes", type=_minutes, default=10.0, help="wall time of faults (default: 10)"
    )
    parser.add_argument(
        "--fault",
        action="append",
        default=[],
        dest="faults",
        metavar="path.py:Class",
        help="a fault of your own, injected before all others; may be repeated",
    )
    parser.add_argument(
        "--soak", type=_hours, metavar="HOURS", help="instead: hours of simulated flight"
    )
    parser.add_argument("--seed", type=int, default=0, help="of everything random (default: 0)")
    parser.add_argument(
        "--case", type=_case, metavar="N", help="only this case of the schedule, to see it again"
    )
    parser.add_argument(
        "--output",
        type=Path,
        default=Path("output/torture"),
        metavar="DIR",
        help="folder for torture.json, timeline.png, nodes.log and the bags of failing cases "
        "(default: output/torture)",
    )
    parser.add_argument(
        "--json", action="store_true", help="print one JSON object and nothing else"
    )
    parser.set_defaults(run=run)
    return parser


def _minutes(text: str) -> float:
    value = float(text)
    if not 0.0 < value <= 10_000.0:
        raise ValueError(f"{text} is not from 0 to 10000")
    return value


def _hours(text: str) -> float:
    value = float(text)
    if not 0.1 <= value <= 1000.0:
        raise ValueError(f"{text} is not from 0.1 to 1000")
    return value


def _case(text: str) -> int:
    if int(text) < 0:
        raise ValueError(f"{text} is negative")
    return int(text)


def run(arguments: argparse.Namespace) -> int:
    """Run the command.

    Args:
        arguments: Of its parser.

    Returns:
        Exit code: 1 if something was violated or a process was lost.
    """
    arguments.output.mkdir(parents=True, exist_ok=True)
    previous = signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        return _campaign(arguments) if arguments.soak is None else _soak(arguments)
    finally:
        signal.signal(signal.SIGTERM, previous)


def _soak(arguments: argparse.Namespace) -> int:
    from uav_tracking_mpc.studies.faults.soak import SPEED, soak

    overrides = [f"mission.speed={SPEED!r}", *arguments.overrides]
    configuration = load_configuration(arguments.config, overrides)
    summary = soak(
        configuration,
        arguments.soak,
        arguments.output,
        Console(stderr=True),
        arguments.domain_id,
    )
    text = _saved(arguments.output / "soak.json", summary)
    print(json.dumps(summary) if arguments.json else text)
    return 1 if summary["violations"] else 0


def _campaign(arguments: argparse.Namespace) -> int:
    from uav_tracking_mpc.studies.faults.catalogue import catalogue, variants
    from uav_tracking_mpc.studies.faults.fault_campaign import (
        RECOVERY_LIMIT,
        TOLERANCE,
        FaultCampaign,
    )
    from uav_tracking_mpc.studies.faults.fault_findings import table
    from uav_tracking_mpc.studies.faults.schedule import schedule
    from uav_tracking_mpc.studies.faults.timeline import timeline

    configuration = load_configuration(arguments.config, arguments.overrides)
    faults = catalogue(arguments.faults)
    first = [label for reference in arguments.faults for label in variants(reference)]
    output: Path = arguments.output
    for bag in (output / "cases").glob("case_*.mcap"):
        bag.unlink()  # of another run
    cases = schedule(faults, arguments.seed, arguments.minutes, first)
    if arguments.case is not None:
        cases = itertools.islice(cases, arguments.case, arguments.case + 1)
    campaign = FaultCampaign(configuration, faults, output, Console(stderr=True)).fly(
        cases, seed=arguments.seed, minutes=arguments.minutes, domain=arguments.domain_id
    )
    summary = campaign.summary()
    _saved(output / "torture.json", summary)
    write_atomically(output / "timeline.png", timeline(campaign, TOLERANCE, RECOVERY_LIMIT))
    print(json.dumps(summary) if arguments.json else table(summary))
    return 1 if summary["violations"] or summary["deaths"] else 0


def _saved(path: Path, summary: dict[str, Any]) -> str:
    """Save a summary as JSON; returns the text."""
    text = json.dumps(summary, indent=2)
    write_atomically(path, (text + "\n").encode())
    return text
