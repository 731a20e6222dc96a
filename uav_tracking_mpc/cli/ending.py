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

"""How a command that failed reports it: one line on stderr and an exit code."""

from __future__ import annotations

import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

# That bring a module.
EXTRAS = {
    "distributed": "dask",
    "mcap": "view",
    "pyarrow": "campaign",
    "pymavlink": "mavlink",
    "viser": "view",
    "websockets": "view",
}
ROS_ENDINGS = ("rclpy", "_msgs", "_srvs", "_interfaces")


@dataclass
class Ending:
    """How a command ended.

    Attributes:
        code: Exit code: 0 done; 1 failed; 2 asked for what is not allowed, or something is missing
            that must be there before it can run at all; 3 flown but not settled (`fly`); 128 + n by
            signal n.
    """

    code: int = 0


@contextmanager
def explained(program: str) -> Iterator[Ending]:
    """Turn the errors that a command expects into one line and an exit code; others pass.

    Args:
        program: What the line begins with.
    """
    ending = Ending()
    try:
        yield ending
    except (Exception, KeyboardInterrupt) as error:
        found = explanation(error)
        if found is None:
            raise
        ending.code, message = found
        print(f"{program}: {message}", file=sys.stderr)


def explanation(error: BaseException) -> tuple[int, str] | None:
    """Exit code and message of an error, or None where it is none that a command expects.

    Args:
        error: What was raised.
    """
    if isinstance(error, KeyboardInterrupt):
        return 128 + signal.SIGINT, "interrupted"
    if isinstance(error, ImportError):
        return _missing(error)
    # Only now: what raises these errors takes longer to import than help takes to print.
    from uav_tracking_mpc.launch.domain import DomainError
    from uav_tracking_mpc.launch.flight import FlightInterruptedError
    from uav_tracking_mpc.launch.supervisor import LaunchError
    from uav_tracking_mpc.links import LinkError
    from uav_tracking_mpc.mpc.compilation import CompilationError
    from uav_tracking_mpc.nodes.ros_environment import DomainValueError, refusal_of_ros
    from uav_tracking_mpc.parameters.registry import ExtensionError
    from uav_tracking_mpc.parameters.specification import ParameterError
    from uav_tracking_mpc.simulation.closed_loop import SimulationError
    from uav_tracking_mpc.studies.campaign.executors import CampaignError

    if isinstance(error, FlightInterruptedError):
        return 128 + error.signal, str(error)
    if isinstance(error, (ParameterError, ExtensionError, LinkError, DomainValueError)):
        return 2, str(error)
    expected = (LaunchError, DomainError, SimulationError, CampaignError, CompilationError, OSError)
    if isinstance(error, expected):
        return 1, str(error)
    refused = refusal_of_ros(error)
    return (2, refused) if refused else None


def _missing(error: ImportError) -> tuple[int, str] | None:
    """A package that is not installed; a module of this one that is missing is a mistake in it."""
    if not isinstance(error, ModuleNotFoundError):
        return 2, str(error)
    if error.name is None or error.name.startswith("uav_tracking_mpc"):
        return None
    package = error.name.partition(".")[0]
    if package in EXTRAS:
        return 2, f"{package} is not installed: `pip install 'uav_tracking_mpc[{EXTRAS[package]}]'`"
    if not package.endswith(ROS_ENDINGS):
        return 2, f"{package} is not installed: `pip install uav_tracking_mpc` brings it"
    return 2, (
        f"{package} is not installed; flying needs ROS 2 Jazzy: source its setup file, or "
        "`pip install 'uav_tracking_mpc[ros]'`"
    )
