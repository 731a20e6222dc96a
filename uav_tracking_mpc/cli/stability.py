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

"""``uav_tracking stability``: what is proved of a configuration, and campaigns that show it."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from uav_tracking_mpc.cli.options import (
    add_configuration_arguments,
    add_output_arguments,
    chosen_configuration,
    existing_file,
    number,
)
from uav_tracking_mpc.cli.program import answer, publish
from uav_tracking_mpc.parameters.specification import ParameterError

if TYPE_CHECKING:
    from uav_tracking_mpc.settings.configuration import Configuration
    from uav_tracking_mpc.studies.study import Study

HELP = "the paper's stability analysis, and a proof of the terminal set"
DESCRIPTION = (
    "Theorems 2 and 3, the paper beside the truth, a proof of the terminal set; for a "
    "configuration with an artificial orbit: what is guaranteed. Exit codes: 0 done (--verify: "
    "accepted), 1 not (rejected, no certified set, or a campaign saw what is guaranteed not to "
    "happen), 2 bad usage."
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options.

    Args:
        parser: Of this command.
    """
    add_configuration_arguments(parser)
    add_output_arguments(parser, "stability.json, certificate.json and figures")
    count = number(int, 1)
    parser.add_argument("--verify", type=existing_file, metavar="FILE", help="check a certificate")
    parser.add_argument(
        "--boxes", type=count, metavar="N", help="budget of each proof in boxes (default: 20000)"
    )
    parser.add_argument("--design", action="store_true", help="search rho and the weights")
    parser.add_argument("--maps", action="store_true", help="map the domain of attraction")
    parser.add_argument("--points", type=count, default=25, help="of a map along each coordinate")
    parser.add_argument("--campaign", type=count, metavar="COUNT", help="fly random states")
    parser.add_argument("--figures", action="store_true", help="draw the ellipsoid, the decrease")
    parser.add_argument("--errata", type=Path, metavar="FILE", help="write the page on the paper")
    parser.add_argument(
        "--jobs", type=count, metavar="N", help="processes for maps and campaigns (default: cores)"
    )


def run(arguments: argparse.Namespace) -> int:
    """Do what the options ask for.

    Args:
        arguments: As parsed.

    Returns:
        Exit code.
    """
    if arguments.errata is not None:
        from uav_tracking_mpc.report.atomic_write import write_atomically
        from uav_tracking_mpc.studies.stability.paper_report import as_markdown, paper_report

        write_atomically(arguments.errata, as_markdown(paper_report()).encode())
        return 0
    if arguments.verify is not None:
        return _verify(arguments)
    from uav_tracking_mpc.settings.tracking import ARTIFICIAL_ORBIT

    configuration = chosen_configuration(arguments)
    with_set = configuration.controller.terminal_constraint != ARTIFICIAL_ORBIT
    return publish((_analysed if with_set else _guaranteed)(arguments, configuration), arguments)


def _verify(arguments: argparse.Namespace) -> int:
    from uav_tracking_mpc.terminal.certificate import read_certificate, verify

    try:
        certificate = read_certificate(arguments.verify)
        reason = verify(certificate)
    except ValueError as error:
        reason = str(error)
    words = f"REJECTED: {reason}"
    if reason is None:
        words = f"accepted: x'P_rho x <= {certificate['level']:.6g} is a terminal set"
    content = {"file": str(arguments.verify), "accepted": reason is None, "reason": reason}
    answer(content, [words], arguments.json)
    return 0 if reason is None else 1


def _guaranteed(arguments: argparse.Namespace, configuration: Configuration) -> Study:
    """The problem has no ellipsoid: say what is guaranteed, and fly random states."""
    from uav_tracking_mpc.studies.feasibility_study import feasibility_study

    for option in ("design", "maps", "figures"):
        if getattr(arguments, option):
            raise ParameterError(
                f"--{option} is about the ellipsoid of the paper's terminal set; configuration "
                f"{configuration.name!r} has an artificial orbit and no such set"
            )
    return feasibility_study(configuration, arguments.campaign or 0, arguments.jobs)


def _analysed(arguments: argparse.Namespace, configuration: Configuration) -> Study:
    from uav_tracking_mpc.formulation.paper_formulation import stability_problem
    from uav_tracking_mpc.studies.stability.proof import BOXES
    from uav_tracking_mpc.studies.stability.stability_study import design, stability_study

    problem = stability_problem(configuration.controller, configuration.name)
    boxes = arguments.boxes or BOXES
    if arguments.design:
        return design(problem, _say, boxes=boxes)
    return stability_study(
        problem,
        boxes=boxes,
        campaign=arguments.campaign or 0,
        points=arguments.points if arguments.maps else 0,
        pictures=arguments.figures,
        workers=arguments.jobs,
        say=_say,
    )


def _say(text: str) -> None:
    print(text, file=sys.stderr, flush=True)
