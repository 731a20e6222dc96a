"""``uav_tracking torture``: fly real nodes under faults, and report what came of it."""

from __future__ import annotations

import argparse
import itertools
import os
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from uav_tracking_mpc.cli.answer import answer
from uav_tracking_mpc.cli.arguments import (
    add_configuration_arguments,
    add_domain_argument,
    add_output_arguments,
    chosen_configuration,
    number,
)

HELP = "inject faults into real nodes and check that nothing breaks"
DESCRIPTION = (
    "Fly with real nodes, inject faults from a seeded schedule, check every message. Or fly for "
    "hours without faults (--soak). Exit code 0 if nothing was violated and no process was lost."
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options.

    Args:
        parser: Of this command.
    """
    add_configuration_arguments(parser, "small_uav")
    add_domain_argument(parser, "ROS domain to fly in (default: one that no other launch uses)")
    parser.add_argument(
        "--minutes", type=number(float, 0.01, 1e4), default=10.0, help="wall time of faults [min]"
    )
    instead = parser.add_mutually_exclusive_group()
    instead.add_argument(
        "--messages",
        type=number(int, 1, 10_000_000),
        metavar="N",
        help="instead: so many messages, right and wrong, on every topic of controller and vehicle",
    )
    instead.add_argument(
        "--soak",
        type=number(float, 0.1, 1000.0),
        metavar="HOURS",
        help="instead: hours of simulated flight",
    )
    parser.add_argument("--seed", type=int, default=0, help="of everything random")
    parser.add_argument(
        "--case",
        type=number(int, 0),
        metavar="N",
        help="only this case of the schedule, to see it again",
    )
    add_output_arguments(
        parser,
        "torture.json, timeline.png, nodes.log and the bags of failing cases",
        "output/torture",
    )


def run(arguments: argparse.Namespace) -> int:
    """Run the campaign.

    Args:
        arguments: As parsed.

    Returns:
        Exit code.
    """
    arguments.output.mkdir(parents=True, exist_ok=True)
    with _own_environment(arguments.domain_id):
        if arguments.messages is not None:
            return _fuzz(arguments)
        return _campaign(arguments) if arguments.soak is None else _soak(arguments)


@contextmanager
def _own_environment(domain: int | None) -> Iterator[None]:
    """A ROS domain for the nodes; SIGTERM ends the campaign as Ctrl-C does."""
    from uav_tracking_mpc.launch.domain import own_domain

    previous = signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        with own_domain(domain) as claimed:
            # rclpy reads the environment when it is loaded.
            os.environ.update(ROS_DOMAIN_ID=str(claimed), RCUTILS_COLORIZED_OUTPUT="0")
            os.environ.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
            yield
    finally:
        signal.signal(signal.SIGTERM, previous)


def _fuzz(arguments: argparse.Namespace) -> int:
    from rich.console import Console
    from rich.progress import Progress

    from uav_tracking_mpc.studies.faults.message_fuzz import fuzz

    console = Console(stderr=True)
    with Progress(console=console, transient=True, disable=not console.is_terminal) as bar:
        tasks = {
            name: bar.add_task(name, total=arguments.messages) for name in ("controller", "vehicle")
        }
        summary = fuzz(
            chosen_configuration(arguments),
            arguments.messages,
            arguments.seed,
            lambda name, done: bar.update(tasks[name], completed=done),
        )
    _report(arguments, "messages.json", summary)
    return 1 if summary["exceptions"] or summary["violations"] else 0


def _soak(arguments: argparse.Namespace) -> int:
    from rich.console import Console

    from uav_tracking_mpc.studies.faults.soak import SPEED, soak

    arguments.overrides = [f"mission.speed={SPEED!r}", *arguments.overrides]
    configuration = chosen_configuration(arguments)
    summary = soak(configuration, arguments.soak, arguments.output, Console(stderr=True))
    _report(arguments, "soak.json", summary)
    return 1 if summary["violations"] else 0


def _campaign(arguments: argparse.Namespace) -> int:
    from rich.console import Console

    from uav_tracking_mpc.report.atomic_write import write_atomically
    from uav_tracking_mpc.studies.faults.fault_campaign import RECOVERY_LIMIT, TOLERANCE, fly
    from uav_tracking_mpc.studies.faults.fault_findings import table
    from uav_tracking_mpc.studies.faults.schedule import schedule
    from uav_tracking_mpc.studies.faults.timeline import timeline

    for bag in (arguments.output / "cases").glob("case_*.mcap"):
        bag.unlink()  # of another run
    cases = schedule(arguments.seed, arguments.minutes)
    if arguments.case is not None:
        cases = itertools.islice(cases, arguments.case, arguments.case + 1)
    campaign = fly(
        chosen_configuration(arguments),
        cases,
        seed=arguments.seed,
        minutes=arguments.minutes,
        output=arguments.output,
        console=Console(stderr=True),
    )
    summary = campaign.summary()
    picture = timeline(campaign, TOLERANCE, RECOVERY_LIMIT)
    write_atomically(arguments.output / "timeline.png", picture)
    _report(arguments, "torture.json", summary, table(summary))
    return 1 if summary["violations"] or summary["deaths"] else 0


def _report(
    arguments: argparse.Namespace, name: str, summary: dict[str, Any], words: str | None = None
) -> None:
    from uav_tracking_mpc.report.atomic_write import json_text, write_json

    write_json(arguments.output / name, summary)
    answer(summary, [words or json_text(summary)], arguments.json)
