"""``uav_tracking torture``: fly under faults, print what came of it, save report and figure."""

from __future__ import annotations

import argparse
import itertools
import json
import os
import signal
from pathlib import Path
from typing import Any

from rich.console import Console

from uav_tracking_mpc.domain import own_domain
from uav_tracking_mpc.launch import add_configuration_arguments, add_launch_arguments
from uav_tracking_mpc.report.atomic_write import write_atomically
from uav_tracking_mpc.simulation.configuration import load_configuration
from uav_tracking_mpc.torture.findings import table
from uav_tracking_mpc.torture.schedule import schedule
from uav_tracking_mpc.torture.timeline import timeline


def add_torture_parser(subparsers: Any) -> argparse.ArgumentParser:
    """Add the command ``torture``; its handler is ``run`` of the namespace."""
    parser = subparsers.add_parser(
        "torture",
        help="inject faults into real nodes and check that nothing breaks",
        description="Fly with real nodes, inject faults from a seeded schedule, check every "
        "message. Exit code 0 if nothing was violated and no process was lost.",
    )
    add_configuration_arguments(parser)
    add_launch_arguments(parser)
    parser.add_argument(
        "--minutes", type=_minutes, default=10.0, help="wall time of faults (default: 10)"
    )
    parser.add_argument("--seed", type=int, default=0, help="of the schedule (default: 0)")
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
    parser.set_defaults(run=main)
    return parser


def _minutes(text: str) -> float:
    value = float(text)
    if not 0.0 < value <= 10_000.0:
        raise ValueError(f"{text} is not from 0 to 10000")
    return value


def _case(text: str) -> int:
    if int(text) < 0:
        raise ValueError(f"{text} is negative")
    return int(text)


def main(arguments: argparse.Namespace) -> int:
    """Run the command; returns the exit code."""
    configuration = load_configuration(arguments.config, arguments.overrides)
    output: Path = arguments.output
    output.mkdir(parents=True, exist_ok=True)
    for bag in (output / "cases").glob("case_*.mcap"):
        bag.unlink()  # of another run
    cases = schedule(arguments.seed, arguments.minutes)
    if arguments.case is not None:
        cases = itertools.islice(cases, arguments.case, arguments.case + 1)
    previous = signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        with own_domain(arguments.domain_id) as domain:
            # rclpy reads the environment when it is loaded.
            os.environ.update(
                ROS_DOMAIN_ID=str(domain),
                ROS_AUTOMATIC_DISCOVERY_RANGE=os.environ.get(
                    "ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST"
                ),
                RCUTILS_COLORIZED_OUTPUT="0",
            )
            from uav_tracking_mpc.torture.campaign import RECOVERY_LIMIT, TOLERANCE, fly

            campaign = fly(
                configuration,
                cases,
                seed=arguments.seed,
                minutes=arguments.minutes,
                output=output,
                console=Console(stderr=True),
            )
    finally:
        signal.signal(signal.SIGTERM, previous)
    summary = campaign.summary()
    text = json.dumps(summary, indent=2) + "\n"
    write_atomically(output / "torture.json", text.encode())
    write_atomically(output / "timeline.png", timeline(campaign, TOLERANCE, RECOVERY_LIMIT))
    print(json.dumps(summary) if arguments.json else table(summary))
    return 1 if summary["violations"] or summary["deaths"] else 0
