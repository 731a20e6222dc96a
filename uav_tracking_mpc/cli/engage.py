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

"""``uav_tracking engage``, and how a command asks the nodes of a flight that is under way."""

from __future__ import annotations

import argparse
import re
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING

from uav_tracking_mpc.cli.options import add_domain_argument
from uav_tracking_mpc.parameters.specification import ParameterError

if TYPE_CHECKING:
    from uav_tracking_mpc.nodes.watching import SteeringRequests


APPEARANCE = 5.0  # s for nodes that fly to be found


def add_flight_arguments(parser: argparse.ArgumentParser, what: str) -> None:
    """The options ``--domain-id`` and ``--namespace``: which flight, and which of its aircraft.

    Args:
        parser: Gets the options.
        what: What is done to it, as a verb.
    """
    add_domain_argument(
        parser, f"ROS domain to {what} (default: ROS_DOMAIN_ID, or 0); a launch prints its own"
    )
    parser.add_argument(
        "--namespace",
        type=_namespace,
        default="/",
        metavar="NAME",
        help=f"of the aircraft to {what}, such as red",
    )


def _namespace(text: str) -> str:
    """A ROS namespace, with or without its first slash."""
    name = text.strip("/")
    if name and not re.fullmatch(r"[A-Za-z_]\w*(/[A-Za-z_]\w*)*", name, re.ASCII):
        raise argparse.ArgumentTypeError(
            f"{text!r} is not a namespace: letters, digits and underscores, no digit first"
        )
    return f"/{name}"


@contextmanager
def flight_requests(
    arguments: argparse.Namespace, owners: Sequence[str] = (), switches: Sequence[str] = ()
) -> Iterator[SteeringRequests]:
    """Requests to the nodes of the aircraft that the options choose.

    Args:
        arguments: Of a parser with :func:`add_flight_arguments`.
        owners: Nodes whose parameters are set.
        switches: Services of type SetBool, each as ``node/service``.

    Raises:
        ConnectionError: A node is not there, or does not answer.
        DomainValueError: The exported domain is not allowed.
    """
    from uav_tracking_mpc.nodes.ros.process import BackgroundNode
    from uav_tracking_mpc.nodes.ros.ros_environment import exported_domain, stay_on_this_machine
    from uav_tracking_mpc.nodes.watching import NoAnswerError, SteeringRequests, asking_node

    stay_on_this_machine()
    asked = arguments.domain_id
    domain = (exported_domain() or 0) if asked is None else asked
    spun = BackgroundNode(asking_node, domain)
    try:
        yield SteeringRequests(spun.node, arguments.namespace, owners, switches, ())
    except NoAnswerError as error:
        raise ConnectionError(
            f"{error}: no such node in namespace {arguments.namespace} of ROS domain {domain}; a "
            "launch prints its domain, --domain-id takes it"
        ) from error
    finally:
        spun.close()


def appears(found: Callable[[], bool]) -> bool:
    """Wait for nodes to be found.

    Args:
        found: Whether they are.
    """
    deadline = time.monotonic() + APPEARANCE
    while not found():
        if time.monotonic() > deadline:
            return False
        time.sleep(0.02)
    return True


HELP = "let the controller command a flight that is under way, or give command back"
DESCRIPTION = (
    "Engage: the controller sends commands and, where autopilot_link flies a real autopilot, that "
    "flies them. With --off command is given back: a real autopilot goes on as it does by itself, "
    "a simulated aircraft flies its plan to the end, then holds its wings level. It calls the "
    "services nmpc_controller/engage and autopilot_link/engage. Exit code 0: done; 2: refused, and "
    "why; 1: there is no such node."
)
CONTROLLER, LINK = "nmpc_controller/engage", "autopilot_link/engage"
SIMULATOR = "uav_simulator/pause"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options.

    Args:
        parser: Of this command.
    """
    parser.add_argument("--off", action="store_true", help="give command back")
    add_flight_arguments(parser, "engage")


def run(arguments: argparse.Namespace) -> int:
    """Engage or disengage.

    Args:
        arguments: As parsed.

    Returns:
        Exit code.

    Raises:
        ParameterError: It was refused.
    """
    with flight_requests(arguments, switches=(CONTROLLER, LINK, SIMULATOR)) as requests:
        # Either may be found first; without a link or a simulator a stranger flies.
        appears(
            lambda: (
                (arguments.off and requests.offered(LINK))
                or (
                    requests.offered(CONTROLLER)
                    and (requests.offered(LINK) or requests.offered(SIMULATOR))
                )
            )
        )
        there = [service for service in (CONTROLLER, LINK) if requests.offered(service)]
        if arguments.off:
            there = there[-1:]
        for service in there or [CONTROLLER]:
            if refused := requests.call(service, data=not arguments.off):
                raise ParameterError(f"{service}: {refused}")
            print(f"{service}: {'off' if arguments.off else 'on'}")
    return 0
