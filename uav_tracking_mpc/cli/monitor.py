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

"""``uav_tracking monitor``: a live table of a flight in the terminal."""

from __future__ import annotations

import argparse
import os

from uav_tracking_mpc.cli.engage import add_flight_arguments

HELP = "a live table of a flight in the terminal"
DESCRIPTION = (
    "Watch a flight that is under way: a live table of its errors and messages, until Ctrl-C. "
    "Where several aircraft fly in the domain, the others are named below the table."
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options.

    Args:
        parser: Of this command.
    """
    add_flight_arguments(parser, "watch")


def run(arguments: argparse.Namespace) -> int:
    """Show the table until the user ends it.

    Args:
        arguments: As parsed.

    Returns:
        Exit code.
    """
    if arguments.domain_id is not None:
        os.environ["ROS_DOMAIN_ID"] = str(arguments.domain_id)
    from uav_tracking_mpc.nodes.monitor import Monitor
    from uav_tracking_mpc.nodes.ros.process import run as run_node
    from uav_tracking_mpc.nodes.ros.ros_environment import stay_on_this_machine

    stay_on_this_machine()
    return run_node("monitor", Monitor, ["--ros-args", "-r", f"__ns:={arguments.namespace}"])
