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

"""What ``ros2 run uav_tracking_mpc NODE --help`` prints, and the documentation's tables.

``make docs`` writes them into ``docs/reference/topics_and_parameters.md``; a test compares.
"""

from __future__ import annotations

import sys
import textwrap
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from uav_tracking_mpc.nodes.topics import (
    AIR_VELOCITY,
    ALL,
    COMMAND,
    DIAGNOSTICS,
    ENGAGED,
    ODOMETRY,
    ORBIT,
    TARGET,
    TARGET_GOAL,
    TARGET_ODOMETRY,
    TRACKING,
    Topic,
)
from uav_tracking_mpc.parameters.specification import Specification, specifications
from uav_tracking_mpc.settings.configuration import SECTIONS

if TYPE_CHECKING:
    from uav_tracking_mpc.report.pages import Table

WIDTH = 96  # characters
HEARD: dict[str, tuple[Topic, ...]] = {
    "uav_simulator": (COMMAND, ORBIT),
    "target_publisher": (TARGET_GOAL,),
    "nmpc_controller": (ODOMETRY, AIR_VELOCITY, TARGET, TARGET_ODOMETRY, ENGAGED),
    "autopilot_link": (COMMAND, ORBIT),
    "monitor": (
        ODOMETRY,
        AIR_VELOCITY,
        TARGET,
        TARGET_ODOMETRY,
        COMMAND,
        *TRACKING.values(),
        DIAGNOSTICS,
    ),
}
SERVICES: dict[str, tuple[str, ...]] = {
    "target_publisher": (
        "~/lose_target (std_srvs/srv/Trigger): nothing is measured for 15 s, for trials.",
    ),
    "autopilot_link": ("~/engage (std_srvs/srv/SetBool): take command, or give it back.",),
    "nmpc_controller": (
        "~/engage (std_srvs/srv/SetBool): send commands, or none; and those of a lifecycle node, "
        "for `ros2 lifecycle set`.",
        "~/kill (std_srvs/srv/Trigger), served by `uav_tracking fly` and `launch_tracking`: "
        "SIGKILL and a new start, for trials.",
    ),
    "uav_simulator": (
        "~/pause (std_srvs/srv/SetBool): simulated time stands still, or runs.",
        "~/reset (std_srvs/srv/Trigger): the vehicle is where it started.",
        "~/lose_state (std_srvs/srv/Trigger): no state is published for 15 s, for trials.",
    ),
}
ARGUMENTS = """\
What ROS is to read stands behind --ros-args:
  -p NAME:=VALUE           set a parameter; numbers that need a point are written with it: 350.0
  --params-file FILE       set those of a YAML file, such as config/small_uav.yaml
  -r __ns:=/NAMESPACE      move all relative names; each aircraft has its own namespace
  -r OLD:=NEW              rename a topic
"""


def sent(name: str) -> list[Topic]:
    """Topics that a node may publish.

    Args:
        name: Of the node.
    """
    heard_only = name == "monitor"
    return [t for t in ALL if name in t.sender or (t.sender == "every node" and not heard_only)]


def help_text(name: str, description: str) -> str:
    """The help of a node.

    Args:
        name: Of the node and of its executable.
        description: What it does, in a sentence.
    """
    command = f"ros2 run uav_tracking_mpc {name}"
    words = [
        f"usage: {command} [--ros-args ARGUMENTS]",
        *("", description, "", ARGUMENTS),
        *_listed("publishes", [_topic(topic) for topic in sent(name)]),
        *_listed("subscribes", [_topic(topic) for topic in HEARD[name]]),
        *_listed("services", SERVICES.get(name, ())),
    ]
    if name in SECTIONS:
        known = [_parameter(item) for item in specifications(SECTIONS[name])]
        words += _listed("parameters (default; what is allowed)", known)
        words.append(f"example: {command} --ros-args --params-file config/small_uav.yaml")
    else:
        words.append(f"example: {command} --ros-args -r __ns:=/red")
    return "\n".join(words)


def _listed(heading: str, entries: Iterable[str]) -> Iterator[str]:
    entries = list(entries)
    if not entries:
        return
    yield f"{heading}:"
    for entry in entries:
        yield textwrap.fill(
            entry,
            WIDTH,
            initial_indent="  ",
            subsequent_indent="      ",
            break_long_words=False,
            break_on_hyphens=False,
        )
    yield ""


def _topic(topic: Topic) -> str:
    return f"{topic.name} ({topic.type_name}): {topic.meaning}"


def _parameter(item: Specification) -> str:
    default = list(item.default) if isinstance(item.default, tuple) else item.default
    words = "true" if default is True else "false" if default is False else repr(default)
    fixed = " Set at the start only." if item.fixed else ""
    return f"{item.name} ({words}; {item.allowed}): {item.description}{fixed}"


def tables() -> dict[str, Table]:
    """Of all topics, and of the parameters of each section, by the name of its place in a page."""
    from uav_tracking_mpc.report.pages import Table  # a node's --help needs none

    topics = [(f"`{each.name}`", each.type_name, each.sender, each.meaning) for each in ALL]
    parameters = {
        section: [
            (f"`{item.name}`", _default(item), item.allowed, _effect(item))
            for item in specifications(kind)
        ]
        for section, kind in SECTIONS.items()
    }
    headings = ("parameter", "default", "allowed", "effect")
    return {
        "topics": Table(("topic", "type", "from", "meaning"), topics),
        **{section: Table(headings, rows) for section, rows in parameters.items()},
    }


def _effect(item: Specification) -> str:
    fixed = " *Fixed: set at the start only.*" if item.fixed else ""
    return item.description + fixed


def _default(item: Specification) -> str:
    value = item.default
    if isinstance(value, tuple):
        return ", ".join(f"{number:.6g}" for number in value)
    if isinstance(value, bool):
        return str(value).lower()
    return f"{value:.6g}" if isinstance(value, float) else str(value)


if __name__ == "__main__":
    for page in sys.argv[1:]:
        for name, table in tables().items():
            table.write_into(Path(page), name)
