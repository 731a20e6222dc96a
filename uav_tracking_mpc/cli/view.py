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

"""``uav_tracking view``: a page that shows a flight, live or recorded, and steers it; its start."""

from __future__ import annotations

import argparse
import importlib
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from uav_tracking_mpc.cli.options import (
    add_configuration_arguments,
    add_domain_argument,
    add_page_arguments,
    chosen_configuration,
)
from uav_tracking_mpc.parameters.specification import ParameterError

if TYPE_CHECKING:
    from uav_tracking_mpc.view.page import Page
    from uav_tracking_mpc.view.watched_flight import FlightSource

HELP = "show a flight on a page: one that is flown, or a bag"
DESCRIPTION = (
    "Serve a page that shows flights as a moving scene: those that are flown in a ROS domain, as "
    "they appear, or a recorded one: any MCAP bag with the topics of the package, a file or a "
    "folder, without ROS. Its limits are those that the controller recorded beside it, or those of "
    "--config. Ctrl-C ends it."
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options.

    Args:
        parser: Of this command.
    """
    parser.add_argument(
        "bag", metavar="BAG", nargs="?", type=Path, help="FILE.mcap, or a bag's folder"
    )
    add_domain_argument(
        parser, "ROS domain to watch (default: ROS_DOMAIN_ID, or 0); a launch prints its own"
    )
    add_configuration_arguments(parser)
    parser.set_defaults(config=None)
    add_page_arguments(parser)


def run(arguments: argparse.Namespace) -> int:
    """Serve until SIGINT or SIGTERM.

    Args:
        arguments: As parsed.

    Returns:
        Exit code.
    """
    check_page()
    source = _live(arguments) if arguments.bag is None else _recorded(arguments)
    with opened_page(source, arguments) as page:
        serve_until_signal(page, source)
    return 0


def _recorded(arguments: argparse.Namespace) -> FlightSource:
    from uav_tracking_mpc.view.recorded_source import RecordedSource

    if arguments.config is None and arguments.overrides:
        raise ParameterError(f"--set {arguments.overrides[0]} needs --config")
    tracking = None if arguments.config is None else chosen_configuration(arguments).controller
    return RecordedSource(arguments.bag, tracking)


def _live(arguments: argparse.Namespace) -> FlightSource:
    from uav_tracking_mpc.nodes.ros.ros_environment import stay_on_this_machine
    from uav_tracking_mpc.view.live_source import LiveSource

    if arguments.config is not None or arguments.overrides:
        raise ParameterError("--config and --set need a BAG: a flight tells its own limits")
    stay_on_this_machine()
    return LiveSource(arguments.domain_id)


def check_page() -> None:
    """Find out before a flight whether its page can be shown.

    Raises:
        ModuleNotFoundError: viser is not installed.
    """
    importlib.import_module("viser")


@contextmanager
def opened_page(source: FlightSource, arguments: argparse.Namespace) -> Iterator[Page]:
    """A page that is served until the context ends; its address is printed on stderr.

    Args:
        source: What is shown; closed with the page.
        arguments: Of a parser with :func:`add_page_arguments`.

    Raises:
        OSError: There is no listening at the address that was asked for.
    """
    import rich

    from uav_tracking_mpc.view.page import Page
    from uav_tracking_mpc.view.serving.browser import is_watched, open_browser

    rich.reconfigure(stderr=True)  # viser speaks through this console; stdout is for answers
    try:
        page = Page(source, arguments.host, arguments.port)
    except BaseException:
        source.close()
        raise
    try:
        print(f"page: {page.address}", file=sys.stderr, flush=True)
        with ExitStack() as window:
            if arguments.host is None and not arguments.no_browser and is_watched():
                window.enter_context(open_browser(page.address))
            yield page
    finally:
        page.close()


def serve_until_signal(page: Page, source: FlightSource) -> None:
    """Serve until SIGINT or SIGTERM, and tell in the terminal what is waited for.

    Args:
        page: That is served.
        source: What it shows.
    """
    from uav_tracking_mpc.launch.flight import signals

    told = ""

    def ended() -> bool:
        nonlocal told
        if (words := source.words) not in ("", told):
            told = words
            print(words, file=sys.stderr)
        return bool(received)

    with signals() as received:  # what comes after it can be interrupted as ever
        page.serve(ended)
