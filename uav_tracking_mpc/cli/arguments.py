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

"""Options that several commands have, and the configuration that they choose.

Options that set a parameter (``--law``, ``--duration``) are short forms of ``--set``: they add to
the same list of overrides, so the last one on the command line wins.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable, Collection
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from uav_tracking_mpc.parameters.registry import Kind
    from uav_tracking_mpc.parameters.specification import Specification
    from uav_tracking_mpc.settings.configuration import Configuration


DOMAIN_WORDS = (
    "ROS domain to fly in (default: ROS_DOMAIN_ID where it is exported, else one that no other "
    "launch uses)"
)


def add_configuration_arguments(parser: argparse.ArgumentParser, default: str = "paper") -> None:
    """Options that choose a configuration and change its parameters.

    Args:
        parser: Gets the options.
        default: Name of the configuration that is taken without ``--config``.
    """
    parser.add_argument(
        "--config", default=default, metavar="NAME|FILE", help="configuration of all nodes"
    )
    parser.add_argument(
        "--set",
        dest="overrides",
        action="append",
        default=[],
        metavar="SECTION.PARAMETER=VALUE",
        help="override a parameter, e.g. nmpc_controller.model=paper; may be repeated",
    )


def add_mission_arguments(
    parser: argparse.ArgumentParser, plant: str, without: Collection[str] = ()
) -> None:
    """Options of every command that flies a mission.

    Args:
        parser: Gets the options.
        plant: Parameter that ``--plant`` sets, as ``SECTION.PARAMETER``.
        without: Parameters of the mission that have no effect there, and hence no option.
    """
    from uav_tracking_mpc.parameters.registry import GUIDANCE_LAW, PLANT
    from uav_tracking_mpc.parameters.specification import specifications
    from uav_tracking_mpc.settings.configuration import MissionParameters, scenario_names

    add_configuration_arguments(parser)
    parser.add_argument(
        "--scenario",
        metavar="NAME|FILE",
        help=f"wind, target and measurements: {', '.join(scenario_names())}",
    )
    for specification in specifications(MissionParameters):
        if isinstance(specification.default, float) and specification.name not in without:
            _add_setting(
                parser,
                specification.name,
                f"mission.{specification.name}",
                _number_of(specification),
                "NUMBER",
                f"{specification.description} ({specification.allowed}; default: the "
                "configuration's)",
            )
    _add_extension(parser, "law", "nmpc_controller.law", GUIDANCE_LAW, "law that flies")
    _add_extension(parser, "plant", plant, PLANT, "vehicle that is flown")
    add_limit_argument(parser)


def add_excite_argument(parser: argparse.ArgumentParser) -> None:
    """The option ``--excite``.

    Args:
        parser: Gets the option.
    """
    from uav_tracking_mpc.control.excitation import USUAL

    parser.add_argument(
        "--excite",
        dest="overrides",
        action="append_const",
        default=[],
        const=_override("nmpc_controller.excitation", list(USUAL)),
        help="add a small test signal to the commands once the aircraft is on its orbit, for "
        "`identify` (sets nmpc_controller.excitation)",
    )


def add_limit_argument(parser: argparse.ArgumentParser) -> None:
    """The option ``--limit``.

    Args:
        parser: Gets the option.
    """
    parser.add_argument(
        "--limit",
        dest="limits",
        action="append",
        default=[],
        metavar="NAME|FILE.py:CLASS",
        help="one more limit for the controller to keep; may be repeated",
    )


def add_domain_argument(parser: argparse.ArgumentParser, words: str) -> None:
    """The option ``--domain-id``.

    Args:
        parser: Gets the option.
        words: What the domain is for, and what is taken without the option.
    """
    from uav_tracking_mpc.nodes.ros_environment import GREATEST_DOMAIN

    parser.add_argument(
        "--domain-id", type=number(int, 0, GREATEST_DOMAIN), metavar="N", help=words
    )


def add_output_arguments(
    parser: argparse.ArgumentParser, content: str, default: str | None = None
) -> None:
    """The options ``--output`` and ``--json``.

    Args:
        parser: Gets the options.
        content: What the folder will hold.
        default: Folder; without one nothing is written unless it is asked for.
    """
    parser.add_argument(
        "--output",
        type=Path,
        default=None if default is None else Path(default),
        metavar="DIR",
        help=f"folder for {content}{'' if default else ' (default: nothing is written)'}",
    )
    parser.add_argument(
        "--json", action="store_true", help="print one JSON object and nothing else"
    )


def existing_file(text: str) -> Path:
    """Type of an option that takes a file which must be there.

    Args:
        text: As typed.

    Raises:
        argparse.ArgumentTypeError: There is no such file.
    """
    path = Path(text)
    if not path.is_file():
        raise argparse.ArgumentTypeError(f"there is no file {text!r}")
    return path


def number(
    convert: Callable[[str], Any], lower: float, upper: float = float("inf")
) -> Callable[[str], Any]:
    """Type of an option that takes a number of a range.

    Args:
        convert: ``int`` or ``float``.
        lower: Least value [-].
        upper: Greatest value [-].

    Returns:
        Converts text; raises ArgumentTypeError, in words, where the value is out of the range.
    """
    limits = f"at least {lower:g}" if upper == float("inf") else f"from {lower:g} to {upper:g}"

    def checked(text: str) -> Any:
        try:
            value = convert(text)
        except ValueError:
            value = None
        if value is None or not lower <= value <= upper:
            kind = "an integer" if convert is int else "a number"
            raise argparse.ArgumentTypeError(f"{text!r} is not {kind} {limits}")
        return value

    return checked


def chosen_configuration(
    arguments: argparse.Namespace, scenario: str | None = None
) -> Configuration:
    """Configuration that the options of a command line choose.

    Args:
        arguments: Of a parser with :func:`add_configuration_arguments`.
        scenario: Name or file of a scenario.

    Raises:
        ParameterError: It does not exist or is not allowed.
    """
    from uav_tracking_mpc.settings.configuration import load_configuration

    return load_configuration(arguments.config, chosen_overrides(arguments, scenario), scenario)


def chosen_overrides(arguments: argparse.Namespace, scenario: str | None = None) -> list[str]:
    """Overrides of a command line, those of ``--limit`` among them.

    Args:
        arguments: Of a parser with :func:`add_configuration_arguments`.
        scenario: Name or file of a scenario.

    Raises:
        ParameterError: There is no such configuration, or it is not allowed.
    """
    from uav_tracking_mpc.settings.configuration import chosen_sections

    overrides: list[str] = list(arguments.overrides)
    more = getattr(arguments, "limits", [])
    if more:
        # Not checked yet: what is set may be a parameter of a limit that is only added here.
        _, sections, _ = chosen_sections(arguments.config, overrides, scenario)
        configured = str(sections["nmpc_controller"].get("limits", ""))
        limits = ",".join(filter(None, [configured, *more]))
        overrides.append(_override("nmpc_controller.limits", limits))
    return overrides


def _add_extension(
    parser: argparse.ArgumentParser, name: str, parameter: str, kind: Kind, words: str
) -> None:
    def found(text: str) -> str:
        from uav_tracking_mpc.parameters.registry import ExtensionError

        if ":" in text:  # names are checked with all other parameters
            try:
                kind.find(text)
            except ExtensionError as error:
                raise argparse.ArgumentTypeError(str(error)) from error
        return text

    words = f"{words}: {', '.join(kind.names)} (sets {parameter})"
    _add_setting(parser, name, parameter, found, "NAME|FILE.py:CLASS", words)


def _add_setting(
    parser: argparse.ArgumentParser,
    name: str,
    parameter: str,
    convert: Callable[[str], Any],
    metavar: str,
    words: str,
) -> None:
    """Add an option that is a short form of ``--set``."""

    def override(text: str) -> str:
        return _override(parameter, convert(text))

    parser.add_argument(
        f"--{name}",
        dest="overrides",
        action="append",
        default=[],
        type=override,
        metavar=metavar,
        help=words,
    )


def _override(parameter: str, value: Any) -> str:
    """``SECTION.PARAMETER=VALUE`` with the value in JSON, which is YAML."""
    return f"{parameter}={json.dumps(value)}"


def _number_of(specification: Specification) -> Callable[[str], float]:
    """A number as text; its range is checked with all other parameters."""

    def convert(text: str) -> float:
        try:
            return float(text)
        except ValueError:
            raise argparse.ArgumentTypeError(f"{text!r} is not {specification.allowed}") from None

    return convert
