"""``launch_tracking``: start the nodes and watch over them."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from contextlib import suppress

from uav_tracking_mpc.cli.arguments import (
    HelpFormatter,
    add_domain_argument,
    add_mission_arguments,
    chosen_configuration,
)
from uav_tracking_mpc.cli.ending import explained


def main(arguments: Sequence[str] | None = None) -> int:
    """Entry point of the executable.

    Args:
        arguments: Command line without the program's name; that of the process by default.

    Returns:
        Exit code, see :class:`uav_tracking_mpc.cli.ending.Ending`.
    """
    parser = argparse.ArgumentParser(
        prog="launch_tracking",
        description="Start simulator, target and controller as processes and watch over them. "
        "Ctrl-C ends them all.",
        formatter_class=HelpFormatter,
    )
    add_mission_arguments(parser, plant="uav_simulator.plant")
    add_domain_argument(parser, "ROS domain to fly in (default: one that no other launch uses)")
    parsed = parser.parse_args(arguments)
    from uav_tracking_mpc.launch.flight import FlightInterruptedError, launch

    # A launcher runs until somebody ends it: a signal is no failure, as for a node.
    with explained("launch_tracking") as ending, suppress(FlightInterruptedError):
        launch(chosen_configuration(parsed, parsed.scenario), domain=parsed.domain_id)
    return ending.code


if __name__ == "__main__":
    sys.exit(main())
