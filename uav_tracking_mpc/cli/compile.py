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

"""``uav_tracking compile``: what a configuration needs compiled, before it flies."""

from __future__ import annotations

import argparse
import time

from uav_tracking_mpc.cli.options import (
    add_configuration_arguments,
    add_limit_argument,
    chosen_configuration,
)
from uav_tracking_mpc.cli.program import answer

HELP = "compile the solver of a configuration, to prepare a companion computer"
DESCRIPTION = (
    "Compile the solver for what a configuration flies and keep it in the user's cache, so that "
    "no flight has to. There is nothing to do where it is kept already. The controller compiles "
    "what it does not find, too, and flies on another solver meanwhile."
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options.

    Args:
        parser: Of this command.
    """
    add_configuration_arguments(parser)
    add_limit_argument(parser)
    parser.add_argument(
        "--json", action="store_true", help="print one JSON object and nothing else"
    )


def run(arguments: argparse.Namespace) -> int:
    """Compile.

    Args:
        arguments: As parsed.

    Returns:
        Exit code.
    """
    from uav_tracking_mpc.control.guidance import compile_flight, compiled_into
    from uav_tracking_mpc.estimation.navigator import Navigator
    from uav_tracking_mpc.mpc import machine_code

    begin = time.perf_counter()
    configuration = chosen_configuration(arguments)
    folder = compiled_into(configuration.controller)
    there = folder is None or machine_code.finished(folder)
    Navigator(configuration.controller)  # whose machine code the end of this process waits for
    compile_flight(configuration.controller)
    seconds = time.perf_counter() - begin
    found = {
        "config": configuration.name,
        "solver": configuration.controller.solver if folder is not None else None,
        "compiled": not there,
        "seconds": 0.0 if there else seconds,
        "folder": None if folder is None else str(folder),
    }
    if folder is None:
        words = f"{configuration.name}: nothing has to be compiled for it"
    elif there:
        words = f"{configuration.name}: solver is compiled already, kept in {folder}"
    else:
        words = f"{configuration.name}: solver compiled in {seconds:.1f} s, kept in {folder}"
    answer(found, [words], arguments.json)
    return 0
