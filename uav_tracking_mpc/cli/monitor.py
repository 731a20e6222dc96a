"""``uav_tracking monitor``: a live table of a flight in the terminal."""

from __future__ import annotations

import argparse
import os

from uav_tracking_mpc.cli.arguments import add_domain_argument

HELP = "a live table of a flight in the terminal"
DESCRIPTION = "Watch a flight that is under way: a live table of its errors and messages."


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options.

    Args:
        parser: Of this command.
    """
    add_domain_argument(
        parser, "ROS domain to watch (default: ROS_DOMAIN_ID, or 0); a launch prints its own"
    )


def run(arguments: argparse.Namespace) -> int:
    """Show the table until the user ends it.

    Args:
        arguments: As parsed.

    Returns:
        Exit code.
    """
    if arguments.domain_id is not None:
        os.environ["ROS_DOMAIN_ID"] = str(arguments.domain_id)
    os.environ.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    from uav_tracking_mpc.nodes.monitor import Monitor
    from uav_tracking_mpc.nodes.run import run as run_node

    return run_node("monitor", Monitor, [])
