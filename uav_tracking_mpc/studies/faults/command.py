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
from rich.progress import Progress

from uav_tracking_mpc.launch.domain import own_domain
from uav_tracking_mpc.launch.launcher import add_configuration_arguments, add_launch_arguments
from uav_tracking_mpc.report.atomic_write import write_atomically
from uav_tracking_mpc.settings.configuration import load_configuration
from uav_tracking_mpc.studies.faults.fault_findings import table
from uav_tracking_mpc.studies.faults.schedule import schedule
from uav_tracking_mpc.studies.faults.timeline import timeline


def add_torture_parser(subparsers: Any) -> argparse.ArgumentParser:
    """Add the command ``torture``; its handler is ``run`` of the namespace."""
    parser = subparsers.add_parser(
        "torture",
        help="inject faults into real nodes and check that nothing breaks",
        description="Fly with real nodes, inject faults from a seeded schedule, check every "
        "message. Or feed the nodes by hand (--messages), or fly for hours without faults "
        "(--soak). Exit code 0 if nothing was violated and no process was lost.",
    )
    add_configuration_arguments(parser, "small_uav")
    add_launch_arguments(parser)
    parser.add_argument(
        "--minutes", type=_minutes, default=10.0, help="wall time of faults (default: 10)"
    )
    instead = parser.add_mutually_exclusive_group()
    instead.add_argument(
        "--messages",
        type=_count,
        metavar="N",
        help="instead: so many messages, right and wrong, on every topic of controller and vehicle",
    )
    instead.add_argument(
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
    parser.set_defaults(run=main)
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


def _count(text: str) -> int:
    if not 1 <= int(text) <= 10_000_000:
        raise ValueError(f"{text} is not from 1 to 10000000")
    return int(text)


def _case(text: str) -> int:
    if int(text) < 0:
        raise ValueError(f"{text} is negative")
    return int(text)


def main(arguments: argparse.Namespace) -> int:
    """Run the command; returns the exit code."""
    arguments.output.mkdir(parents=True, exist_ok=True)
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
            if arguments.messages is not None:
                return _fuzz(arguments)
            if arguments.soak is not None:
                return _soak(arguments)
            return _campaign(arguments)
    finally:
        signal.signal(signal.SIGTERM, previous)


def _fuzz(arguments: argparse.Namespace) -> int:
    from uav_tracking_mpc.studies.faults.message_fuzz import fuzz

    configuration = load_configuration(arguments.config, arguments.overrides)
    console = Console(stderr=True)
    with Progress(console=console, transient=True, disable=not console.is_terminal) as bar:
        tasks = {
            name: bar.add_task(name, total=arguments.messages) for name in ("controller", "vehicle")
        }
        summary = fuzz(
            configuration,
            arguments.messages,
            arguments.seed,
            lambda name, done: bar.update(tasks[name], completed=done),
        )
    _say(arguments, "messages.json", summary)
    return 1 if summary["exceptions"] or summary["violations"] else 0


def _soak(arguments: argparse.Namespace) -> int:
    from uav_tracking_mpc.studies.faults.soak import SPEED, soak

    overrides = [f"mission.speed={SPEED!r}", *arguments.overrides]
    configuration = load_configuration(arguments.config, overrides)
    summary = soak(configuration, arguments.soak, arguments.output, Console(stderr=True))
    _say(arguments, "soak.json", summary)
    return 1 if summary["violations"] else 0


def _say(arguments: argparse.Namespace, name: str, summary: dict[str, Any]) -> None:
    text = json.dumps(summary, indent=2)
    write_atomically(arguments.output / name, (text + "\n").encode())
    print(json.dumps(summary) if arguments.json else text)


def _campaign(arguments: argparse.Namespace) -> int:
    from uav_tracking_mpc.studies.faults.fault_campaign import RECOVERY_LIMIT, TOLERANCE, fly

    configuration = load_configuration(arguments.config, arguments.overrides)
    output: Path = arguments.output
    for bag in (output / "cases").glob("case_*.mcap"):
        bag.unlink()  # of another run
    cases = schedule(arguments.seed, arguments.minutes)
    if arguments.case is not None:
        cases = itertools.islice(cases, arguments.case, arguments.case + 1)
    campaign = fly(
        configuration,
        cases,
        seed=arguments.seed,
        minutes=arguments.minutes,
        output=output,
        console=Console(stderr=True),
    )
    summary = campaign.summary()
    text = json.dumps(summary, indent=2) + "\n"
    write_atomically(output / "torture.json", text.encode())
    write_atomically(output / "timeline.png", timeline(campaign, TOLERANCE, RECOVERY_LIMIT))
    print(json.dumps(summary) if arguments.json else table(summary))
    return 1 if summary["violations"] or summary["deaths"] else 0
