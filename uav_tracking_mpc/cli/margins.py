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

"""``uav_tracking margins``: how much the closed loop bears beyond what the controller is told."""

from __future__ import annotations

import argparse

from uav_tracking_mpc.cli.options import (
    add_configuration_arguments,
    add_limit_argument,
    add_output_arguments,
    chosen_configuration,
    chosen_overrides,
)
from uav_tracking_mpc.cli.program import publish
from uav_tracking_mpc.parameters.specification import ParameterError

HELP = "stability margins of the closed loop about the orbit"
DESCRIPTION = (
    "Gain, phase, delay and disk margins of the sampled closed loop about the orbit, lag and dead "
    "time included, for each channel and for all at once: flown in still air with all estimators, "
    "by the linearised model beside it, and by that in the wind of a scenario at the worst phase "
    "of the orbit, frozen. With --search, choose weights instead. Exit code 0: computed; whether "
    "they are as large as nmpc_controller.delay_margin_min and gain_margin_min ask is said."
)
SCENARIO = "crosswind"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options.

    Args:
        parser: Of this command.
    """
    from uav_tracking_mpc.settings.configuration import scenario_names

    add_configuration_arguments(parser, default="small_uav")
    add_limit_argument(parser)
    parser.add_argument(
        "--scenario",
        metavar="NAME|FILE",
        help=f"whose wind and target make the drift: {', '.join(scenario_names())} "
        f"(default: {SCENARIO} with the artificial orbit, else still air)",
    )
    parser.add_argument(
        "--search",
        action="store_true",
        help="search for weights of range, inputs and their rates that fly well and keep the "
        "margins; print every candidate and the YAML to paste",
    )
    content = "margins.json and margins.png, or search.json"
    add_output_arguments(parser, content, page="the table")


def run(arguments: argparse.Namespace) -> int:
    """Compute the margins, or search for weights.

    Args:
        arguments: As parsed.

    Returns:
        Exit code.
    """
    from uav_tracking_mpc.settings.tracking import ARTIFICIAL_ORBIT

    if arguments.search:
        from uav_tracking_mpc.studies.margins.weight_search import search_weights

        if arguments.scenario is not None:
            raise ParameterError(f"--search flies mismatches of {SCENARIO}: leave out --scenario")
        overrides = chosen_overrides(arguments, SCENARIO)
        return publish(search_weights(arguments.config, overrides), arguments)
    from uav_tracking_mpc.studies.margins.margin_study import margin_study, margins

    configuration = chosen_configuration(arguments, arguments.scenario)
    in_drift = configuration.controller.terminal_constraint == ARTIFICIAL_ORBIT
    if arguments.scenario is None and in_drift:
        configuration = chosen_configuration(arguments, SCENARIO)
    return publish(margins(margin_study(configuration)), arguments)
