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

"""``uav_tracking autopilot``: a simulated ArduPlane or PX4 to try a link on."""

from __future__ import annotations

import argparse
import signal
import sys

from uav_tracking_mpc.cli.options import (
    add_configuration_arguments,
    chosen_configuration,
    number,
    place,
)

HELP = "a simulated ArduPlane or PX4 behind MAVLink"
DESCRIPTION = """\
Fly a simulated autopilot in real time until Ctrl-C: the plant of the configuration's section
uav_simulator behind a MAVLink server with modes, acknowledgements, parameters, telemetry, inner
loops, time-outs and failsafes as the real one has them. It begins in the air, in a loiter about
its start. A ground station on the same wire can change its mode as a pilot would. Where it differs
from the real one: docs/autopilots.md.
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options.

    Args:
        parser: Of this command.
    """
    add_configuration_arguments(parser, "small_uav")
    parser.add_argument(
        "--dialect", choices=("ardupilot", "px4"), default="ardupilot", help="which autopilot"
    )
    parser.add_argument(
        "--connection",
        default="udpout:127.0.0.1:14550",
        metavar="KIND:PLACE",
        help="its end of the wire: udpout:HOST:PORT, udpin:HOST:PORT, tcpin:HOST:PORT, "
        "tcp:HOST:PORT or serial:DEVICE:BAUD; the link has the other end, such as "
        "udpin:127.0.0.1:14550",
    )
    parser.add_argument(
        "--origin",
        type=place,
        default="47.3977,8.5456,488",
        metavar="LAT,LON,ALT",
        help="where map's origin and its home are: degrees, and metres above sea level; write "
        "--origin=-33.9,18.4,40 south of the equator",
    )
    parser.add_argument(
        "--system", type=number(int, 1, 255), default=1, metavar="N", help="its MAVLink system"
    )
    parser.add_argument(
        "--on-runway",
        action="store_true",
        help="begin on the ground below the start, disarmed; armed in mode TAKEOFF it takes off",
    )
    parser.add_argument(
        "--target-system",
        type=number(int, 0, 255),
        default=0,
        metavar="N",
        help="MAVLink system of a second vehicle to circle, which moves as the configuration's "
        "section target_publisher says; 0 for none",
    )
    parser.add_argument(
        "--signing-key",
        default="",
        metavar="FILE",
        help="sign messages with the 32 bytes of this file, and take no others",
    )


def run(arguments: argparse.Namespace) -> int:
    """Fly until the user ends it.

    Args:
        arguments: As parsed.

    Returns:
        Exit code.
    """
    from uav_tracking_mpc.autopilot.simulated_autopilot import SimulatedAutopilot

    flown = SimulatedAutopilot(
        arguments.dialect,
        chosen_configuration(arguments),
        arguments.connection,
        arguments.origin,
        arguments.system,
        arguments.on_runway,
        arguments.signing_key,
        arguments.target_system,
    )
    print(
        f"{arguments.dialect}: system {arguments.system}, mode {flown.core.mode}, at "
        f"{arguments.connection}; Ctrl-C ends",
        file=sys.stderr,
    )
    previous = signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        flown.run()
    except KeyboardInterrupt:
        pass  # the usual end
    finally:
        flown.stop()
        signal.signal(signal.SIGTERM, previous)
    return 0
