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

"""Options that several commands have, and what they choose: configuration, autopilot, page."""

from __future__ import annotations

import argparse
import importlib
import json
import math
from collections.abc import Callable, Collection
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from uav_tracking_mpc.parameters.registry import ExtensionError, names_of
from uav_tracking_mpc.parameters.specification import ParameterError, changed, specifications

if TYPE_CHECKING:
    from uav_tracking_mpc.launch.preflight import Preflight
    from uav_tracking_mpc.settings.configuration import Configuration

CONNECT_LIMIT = 10.0  # s to find an autopilot
FORMS = "udpin:HOST:PORT, udpout:HOST:PORT, tcp:HOST:PORT, tcpin:HOST:PORT or serial:DEVICE:BAUD"
SECTION = "autopilot_link"
SIMULATED = "ardupilot", "px4"  # links behind which an autopilot can be simulated
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
    from uav_tracking_mpc.settings.configuration import MissionParameters, scenario_names

    add_configuration_arguments(parser)
    parser.add_argument(
        "--scenario",
        metavar="NAME|FILE",
        help=f"wind, target and measurements: {', '.join(scenario_names())}",
    )
    for specification in specifications(MissionParameters):
        if isinstance(specification.default, float) and specification.name not in without:
            parser.add_argument(
                f"--{specification.name}",
                action=_Setting,
                parameter=f"mission.{specification.name}",
                type=number(float, -math.inf, allowed=specification.allowed),
                metavar="NUMBER",
                help=f"{specification.description} ({specification.allowed}; default: the "
                "configuration's)",
            )
    _add_extension(parser, "law", "nmpc_controller.law", "laws", "GUIDANCE_LAW", "law that flies")
    _add_extension(parser, "plant", plant, "simulation.plants", "PLANT", "vehicle that is flown")
    add_limit_argument(parser)


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
    words = []
    for name in ("host", "port"):
        if (value := getattr(arguments, name)) is not None:
            words += [f"--{name}", str(value)]
    words += ["--no-browser"] if arguments.no_browser else []
    if words and not arguments.view:
        raise ParameterError(f"{words[0]} needs --view")
    return words


def add_excite_argument(parser: argparse.ArgumentParser) -> None:
    """The option ``--excite``.

    Args:
        parser: Gets the option.
    """
    parser.add_argument(
        "--excite",
        action="store_true",
        help="add a small test signal to the commands once the aircraft is on its orbit, for "
        "`identify` (sets nmpc_controller.excitation by the airspeed, unless it is set)",
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
    from uav_tracking_mpc.nodes.ros.ros_environment import GREATEST_DOMAIN

    parser.add_argument(
        "--domain-id", type=number(int, 0, GREATEST_DOMAIN), metavar="N", help=words
    )


def add_output_arguments(
    parser: argparse.ArgumentParser, content: str, default: str | None = None, page: str = ""
) -> None:
    """The options ``--output`` and ``--json``, and ``--page`` where there are tables for one.

    Args:
        parser: Gets the options.
        content: What the folder will hold, and which it is where that depends on something.
        default: Folder; without one nothing is written unless it is asked for.
        page: What can be put into a page of the documentation.
    """
    told = default or "default" in content
    parser.add_argument(
        "--output",
        type=Path,
        default=None if default is None else Path(default),
        metavar="DIR",
        help=f"folder for {content}{'' if told else ' (default: nothing is written)'}",
    )
    parser.add_argument(
        "--json", action="store_true", help="print one JSON object and nothing else"
    )
    if page:
        words = f"put {page} into a page of the documentation"
        parser.add_argument("--page", type=existing_file, metavar="FILE", help=words)


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
    convert: Callable[[str], Any], lower: float, upper: float = math.inf, allowed: str = ""
) -> Callable[[str], Any]:
    """Type of an option that takes a number of a range.

    Args:
        convert: ``int`` or ``float``.
        lower: Least value [-].
        upper: Greatest value [-].
        allowed: What is allowed, in words, where the range is checked with all other parameters.

    Returns:
        Converts text; raises ArgumentTypeError, in words, where the value is out of the range.
    """
    limits = f"at least {lower:g}" if upper == math.inf else f"from {lower:g} to {upper:g}"
    words = allowed or f"{'an integer' if convert is int else 'a number'} {limits}"

    def checked(text: str) -> Any:
        try:
            value = convert(text)
        except ValueError:
            value = None
        if value is None or not lower <= value <= upper:
            raise argparse.ArgumentTypeError(f"{text!r} is not {words}")
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
    from uav_tracking_mpc.settings.tracking import usual_excitation

    overrides = chosen_overrides(arguments, scenario)
    configuration = load_configuration(arguments.config, overrides, scenario)
    if ":" in configuration.controller.law:  # names are checked with all other parameters
        from uav_tracking_mpc.control.guidance import law_of

        law_of(configuration.controller)  # refused here, before several parts of a flight do so
    tracking = configuration.controller
    if getattr(arguments, "excite", False) and not any(tracking.excitation):
        signal = {"excitation": usual_excitation(tracking.airspeed)}
        configuration = replace(configuration, controller=changed(tracking, signal))
    return configuration


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
    parser: argparse.ArgumentParser, name: str, parameter: str, room: str, point: str, words: str
) -> None:
    room = f"uav_tracking_mpc.{room}"

    def found(text: str) -> str:
        if ":" in text:  # names are checked with all other parameters
            try:
                getattr(importlib.import_module(room), point).find(text)
            except ExtensionError as error:
                raise argparse.ArgumentTypeError(str(error)) from error
        return text

    parser.add_argument(
        f"--{name}",
        action=_Setting,
        parameter=parameter,
        type=found,
        default=[],
        metavar="NAME|FILE.py:CLASS",
        help=f"{words}: {', '.join(names_of(room))} (sets {parameter})",
    )


class _Setting(argparse.Action):
    """An option that is a short form of ``--set PARAMETER=VALUE``; its value is kept, too.

    Args:
        names: As of :class:`argparse.Action`.
        parameter: As ``SECTION.PARAMETER``; by default that of the link with the option's name.
        options: As of :class:`argparse.Action`.
    """

    def __init__(self, *names: Any, parameter: str = "", **options: Any) -> None:
        super().__init__(*names, **options)
        self.parameter = parameter or f"{SECTION}.{self.dest}"

    def __call__(
        self,
        parser: argparse.ArgumentParser,
        namespace: argparse.Namespace,
        values: Any,
        option_string: str | None = None,
    ) -> None:
        """Add the override.

        Args:
            parser: Of the option.
            namespace: Changed in place.
            values: Of the option, as converted.
            option_string: As typed.
        """
        value = self.const if self.nargs == 0 else values
        setattr(namespace, self.dest, value)
        namespace.overrides = [*namespace.overrides, _override(self.parameter, value)]


def _override(parameter: str, value: Any) -> str:
    """``SECTION.PARAMETER=VALUE`` with the value in JSON, which is YAML."""
    return f"{parameter}={json.dumps(value)}"


def add_link_arguments(parser: argparse.ArgumentParser, flown: bool) -> None:
    """Options that choose a vehicle link.

    Args:
        parser: Gets the options.
        flown: Whether it is to fly, not only to be looked at.
    """
    names = [name for name in names_of("uav_tracking_mpc.links") if name != "simulated"]
    words = "fly a real autopilot" if flown else "autopilot to look at"

    def add(name: str, metavar: str, words: str, convert: Callable[[str], Any] = str) -> None:
        parser.add_argument(f"--{name}", action=_Setting, type=convert, metavar=metavar, help=words)

    default = "none: the simulator flies" if flown else "the configuration's"
    add("link", "NAME|FILE.py:CLASS", f"{words}: {', '.join(names)} (default: {default})")
    add("connection", "KIND:PLACE", f"where it is: {FORMS} (default: udpin:127.0.0.1:14550)")
    add(
        "origin",
        "LAT,LON,ALT",
        "origin of map in degrees and metres above sea level; write --origin=-33.9,18.4,40 south "
        "of the equator (default: the autopilot's home)",
        place,
    )
    add(
        "target-system",
        "N",
        "circle the vehicle of this MAVLink system, which sends GLOBAL_POSITION_INT or "
        "FOLLOW_TARGET, in the place of the configuration's target",
        number(int, 1, 255),
    )
    add("signing-key", "FILE", "file with the 32 bytes of a key to sign messages with")
    if not flown:
        return
    parser.add_argument(
        "--engage",
        action=_Setting,
        nargs=0,
        const=True,
        default=False,
        help="take command as soon as nothing speaks against it; without it "
        "`uav_tracking engage` does",
    )
    parser.add_argument(
        "--simulated",
        action="store_true",
        help="start a simulated autopilot of this kind and fly that (see `autopilot`)",
    )


def check_link_arguments(arguments: argparse.Namespace) -> None:
    """Refuse options that contradict each other.

    Args:
        arguments: Of a parser with :func:`add_link_arguments` for a flight.

    Raises:
        ParameterError: They do.
    """
    if arguments.simulated and arguments.connection is not None:
        raise ParameterError("--simulated has a connection of its own: leave --connection out")
    if arguments.simulated and arguments.link not in (None, *SIMULATED):
        raise ParameterError(f"--simulated flies a link of {' or '.join(SIMULATED)} alone")
    if arguments.link is None:
        for name in ("connection", "origin", "target_system", "signing_key", "engage", "simulated"):
            if getattr(arguments, name):
                raise ParameterError(f"--{name.replace('_', '-')} needs --link NAME")


def place(text: str) -> tuple[float, float, float]:
    """Latitude [deg], longitude [deg] and altitude above sea level [m] of ``LAT,LON,ALT``.

    Args:
        text: As typed.

    Raises:
        argparse.ArgumentTypeError: It is no place.
    """
    try:
        latitude, longitude, altitude = (float(part) for part in text.split(","))
    except ValueError:
        latitude = math.nan
    if not (abs(latitude) <= 90.0 and abs(longitude) <= 360.0 and abs(altitude) < 1e5):
        raise argparse.ArgumentTypeError(
            f"{text!r} is not LAT,LON,ALT, such as 47.3977,8.5456,488"
        ) from None
    return latitude, longitude, altitude


def preflight_lines(found: Preflight) -> list[str]:
    """What was found before the flight, for people.

    Args:
        found: By :func:`~uav_tracking_mpc.launch.preflight.preflight`.
    """
    inspection, controller = found.inspection, found.configuration.controller
    lines = [f"{name}: {words}" for name, words in inspection.found.items()]
    if found.wind is not None:
        east, north, _ = found.wind.tolist()
        lines.append(f"wind: {east:.1f} m/s to the east, {north:.1f} m/s to the north")
    lines += [f"envelope: {words}" for words in found.changes]
    lines += [f"warning: {words}" for words in inspection.warnings]
    if found.refusals:
        return lines
    bank = math.degrees(controller.bank_max)
    return [
        *lines,
        f"orbit: {controller.orbit.in_short}, {controller.direction}; it fits: bank up to "
        f"{bank:.0f} deg, airspeed {controller.airspeed_min:.1f} to "
        f"{controller.airspeed_max:.1f} m/s, not below {controller.height_min:g} m",
    ]
