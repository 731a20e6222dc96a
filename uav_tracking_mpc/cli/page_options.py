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

"""Options of every command that shows a page, and the page that they choose."""

from __future__ import annotations

import argparse
import importlib
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from typing import TYPE_CHECKING

from uav_tracking_mpc.cli.options import number

if TYPE_CHECKING:
    from uav_tracking_mpc.view.page import Page
    from uav_tracking_mpc.view.watched_flight import FlightSource


def add_page_arguments(parser: argparse.ArgumentParser) -> None:
    """The options ``--host``, ``--port`` and ``--no-browser``.

    Args:
        parser: Gets the options.
    """
    parser.add_argument(
        "--host",
        metavar="ADDRESS",
        help="listen at this address of the machine, 0.0.0.0 for all, so that others reach the "
        "page, with the token in the address that is printed (default: 127.0.0.1)",
    )
    parser.add_argument(
        "--port",
        type=number(int, 0, 65535),
        metavar="N",
        help="port of the page, 0 for any free one (default: the first free one from 8080 on)",
    )
    parser.add_argument(
        "--no-browser",
        action="store_true",
        help="do not open the browser (it is opened where there is a screen, without --host)",
    )


def add_view_argument(parser: argparse.ArgumentParser, words: str) -> None:
    """The option ``--view`` of a command that can go without a page, and those of the page.

    Args:
        parser: Gets the options.
        words: What is shown, and for how long.
    """
    parser.add_argument("--view", action="store_true", help=words)
    add_page_arguments(parser)


def told_page_arguments(arguments: argparse.Namespace) -> list[str]:
    """The options of the page that were given, as words of a command line.

    Args:
        arguments: Of a parser with :func:`add_view_argument`.

    Raises:
        ParameterError: There are some, but no page.
    """
    from uav_tracking_mpc.parameters.specification import ParameterError

    words = []
    for name in ("host", "port"):
        if (value := getattr(arguments, name)) is not None:
            words += [f"--{name}", str(value)]
    words += ["--no-browser"] if arguments.no_browser else []
    if words and not arguments.view:
        raise ParameterError(f"{words[0]} needs --view")
    return words


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
