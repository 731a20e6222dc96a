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

"""What ROS finds in the environment and on a command line, and why it does not start with it."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

VARIABLE = "ROS_DOMAIN_ID"
GREATEST_DOMAIN = 232  # domains: what DDS's port numbers leave room for
SECURED = (
    "ROS_SECURITY_ENABLE is true, which needs ROS_SECURITY_KEYSTORE and a ROS 2 with the security "
    "plugins of DDS: the wheels have none (docs/security.md)"
)


class DomainValueError(ValueError):
    """ROS_DOMAIN_ID is exported with a value that is not allowed; the message says which are."""


def exported_domain() -> int | None:
    """Domain that the environment asks for, as every ROS program understands it.

    Returns:
        None where it asks for none.

    Raises:
        DomainValueError: It is no integer from 0 to 232.
    """
    text = os.environ.get(VARIABLE, "").strip()
    if not text:
        return None
    if not (text.isascii() and text.isdigit() and int(text) <= GREATEST_DOMAIN):
        raise DomainValueError(
            f"environment variable {VARIABLE} is {text!r}, must be an integer from 0 to "
            f"{GREATEST_DOMAIN}"
        )
    return int(text)


def refusal_of_ros(error: BaseException) -> str:
    """Why ROS does not start, in words; empty where the error is none of rcl.

    Args:
        error: What rclpy raised.
    """
    kind = type(error)  # compared by name: rclpy may not be installed
    if kind.__module__ != "rclpy._rclpy_pybind11":
        return ""
    words = str(error)
    if kind.__name__ == "UnknownROSArgsError":  # whose text is a list in Python
        return f"arguments that ROS does not know: {words.strip('[]')}"
    if kind.__name__ != "RCLError":
        return ""
    words = words.partition(", at /")[0]  # in which file of rcl is nobody's concern
    if os.environ.get("ROS_SECURITY_ENABLE", "").lower() == "true":
        words = f"{words}; {SECURED}"
    return f"ROS does not start: {' '.join(words.split())}"


RANGE, PROFILES = "ROS_AUTOMATIC_DISCOVERY_RANGE", "FASTRTPS_DEFAULT_PROFILES_FILE"


def stay_on_this_machine() -> None:
    """Let ROS stay on this machine, unless the environment says how far it goes.

    Fast DDS is given sockets of the loopback alone (``config/loopback.xml``). What ROS calls
    LOCALHOST uses shared memory, too, whatever FASTDDS_BUILTIN_TRANSPORTS says: a process that is
    killed leaves it as it was at that moment, and others may hear nothing new from then on
    (eProsima/Fast-DDS#5469). Processes that are started from here inherit the choice.
    """
    if RANGE in os.environ:
        return
    from uav_tracking_mpc.settings.configuration import configuration_folder

    fast = os.environ.get("RMW_IMPLEMENTATION", "rmw_fastrtps_cpp").startswith("rmw_fastrtps")
    profile = str(configuration_folder() / "loopback.xml")
    if fast and os.environ.setdefault(PROFILES, profile) == profile:
        os.environ[RANGE] = "SYSTEM_DEFAULT"
    else:
        os.environ[RANGE] = "LOCALHOST"


LOG_VARIABLE = "ROS_LOG_DIR"


def ensure_log_folder() -> str:
    """Let rcl log under the temporary directory where its own folder cannot be written.

    Its own is ``$ROS_LOG_DIR``, else ``$ROS_HOME/log``, else ``~/.ros/log``. Processes that are
    started from here inherit the choice.

    Returns:
        What was changed, in words; empty where nothing had to be.
    """
    wanted = _wanted()
    if wanted is not None and _writable(wanted):
        return ""
    user = os.getuid() if hasattr(os, "getuid") else "user"
    folder = Path(tempfile.gettempdir()) / f"ros-log-{user}"
    if not _writable(folder):
        folder = Path(tempfile.mkdtemp(prefix="ros-log-"))
    os.environ[LOG_VARIABLE] = str(folder)
    return f"log folder {wanted or '~/.ros/log'} cannot be written, {folder} is used instead"


def _wanted() -> Path | None:
    """Where rcl logs; None where it cannot know."""
    if folder := os.environ.get(LOG_VARIABLE):
        return _expanded(folder)
    home = _expanded(os.environ.get("ROS_HOME") or "~/.ros")
    return None if home is None else home / "log"


def _expanded(folder: str) -> Path | None:
    home = "HOME" if os.name == "posix" else "USERPROFILE"
    if folder.startswith("~") and not os.environ.get(home):  # rcl looks nowhere else
        return None
    return Path(folder).expanduser()


def _writable(folder: Path) -> bool:
    """Whether it is there, or can be made, and takes files."""
    try:
        folder.mkdir(mode=0o755, parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return True
    except OSError:
        return False
