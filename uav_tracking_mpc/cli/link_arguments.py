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

"""Options that say which autopilot flies and where it is, and how what is found there is told."""

from __future__ import annotations

import argparse
import json
import math
from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from uav_tracking_mpc.cli.arguments import number

if TYPE_CHECKING:
    from uav_tracking_mpc.launch.preflight import Preflight
    from uav_tracking_mpc.settings.configuration import Configuration

CONNECT_LIMIT = 10.0  # s to find an autopilot
FORMS = "udpin:HOST:PORT, udpout:HOST:PORT, tcp:HOST:PORT, tcpin:HOST:PORT or serial:DEVICE:BAUD"
SECTION = "autopilot_link"


class _Setting(argparse.Action):
    """An option that is a short form of ``--set autopilot_link.NAME=VALUE``, and is kept, too."""

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
        value = True if self.nargs == 0 else values
        setattr(namespace, self.dest, value)
        override = f"{SECTION}.{self.dest}={json.dumps(value)}"
        namespace.overrides = [*namespace.overrides, override]


def add_link_arguments(parser: argparse.ArgumentParser, flown: bool) -> None:
    """Options that choose a vehicle link.

    Args:
        parser: Gets the options.
        flown: Whether it is to fly, not only to be looked at.
    """
    from uav_tracking_mpc.parameters.registry import VEHICLE_LINK

    names = [name for name in VEHICLE_LINK.names if name != "simulated"]
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
    from uav_tracking_mpc.parameters.specification import ParameterError

    if arguments.simulated and arguments.connection is not None:
        raise ParameterError("--simulated has a connection of its own: leave --connection out")
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


def with_connection(configuration: Configuration, connection: str) -> Configuration:
    """The configuration with another place of the autopilot.

    Args:
        configuration: To be flown.
        connection: Where the autopilot is.
    """
    sections = {**configuration.sections}
    sections[SECTION] = {**sections[SECTION], "connection": connection}
    link = replace(configuration.link, connection=connection)
    return replace(configuration, link=link, sections=sections)


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
