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

"""``uav_tracking set``: parameters of a flight that is under way."""

from __future__ import annotations

import argparse
from functools import partial

from uav_tracking_mpc.cli.engage import add_flight_arguments, appears, flight_requests
from uav_tracking_mpc.parameters.registry import did_you_mean
from uav_tracking_mpc.parameters.specification import ParameterError

HELP = "change parameters of a flight that is under way"
DESCRIPTION = (
    "Set parameters of nodes that fly: the orbit (nmpc_controller.range=350), its weights, the "
    "simulator's wind (uav_simulator.wind=[6,0,0]), the target's motion "
    "(target_publisher.motion=circle). Those of one node are taken together or not at all. Exit "
    "code 0: done; 2: refused, in the node's own words; 1: there is no such node."
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options.

    Args:
        parser: Of this command.
    """
    parser.add_argument(
        "assignments",
        nargs="+",
        metavar="NODE.PARAMETER=VALUE",
        help="what to set, with the value in YAML",
    )
    add_flight_arguments(parser, "change")


def run(arguments: argparse.Namespace) -> int:
    """Set the parameters, node by node.

    Args:
        arguments: As parsed.

    Returns:
        Exit code.

    Raises:
        ParameterError: One was refused.
    """
    from uav_tracking_mpc.settings.configuration import SECTIONS, Sections, override

    nodes: Sections = {section: {} for section in SECTIONS if section != "mission"}
    for assignment in arguments.assignments:
        override(nodes, assignment)
    asked = {owner: values for owner, values in nodes.items() if values}
    with flight_requests(arguments, owners=tuple(asked)) as requests:
        for owner, values in asked.items():
            appears(partial(requests.offered, owner))
            known = requests.parameters(owner)
            for name in values:
                if name not in known:
                    meant = did_you_mean(name, known)
                    raise ParameterError(f"{owner} has no parameter '{name}'{meant}")
            try:
                refused = requests.change(owner, values)
            except (TypeError, ValueError) as error:  # no value that ROS can hold
                refused = str(error)
            if refused:
                raise ParameterError(f"{owner}: {refused}")
            for name, value in values.items():
                print(f"{owner}.{name}: {value}")
    return 0
