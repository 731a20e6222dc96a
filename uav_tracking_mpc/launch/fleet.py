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

"""What several aircraft under one launch file need: namespaces, starts, topics and a view of all.

The files in ``launch/`` at the top are for ROS 2 as people install it; what they compute is here.
"""

from __future__ import annotations

import copy
import math
import re
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import yaml

from uav_tracking_mpc.parameters.specification import ParameterError
from uav_tracking_mpc.settings.configuration import Configuration

MOST = 20  # aircraft on one machine
AIRCRAFT = "Aircraft"  # the group of displays that every aircraft gets
TRANSFORMS = ("/tf", "/tf_static")
NAMESPACE = re.compile(r"(/?[A-Za-z_]\w*(/[A-Za-z_]\w*)*)?", re.ASCII)

SWITCH = ("true", "false")
# Launch arguments of one aircraft and of several by name: default, what is allowed, and meaning.
AIRCRAFT_ARGUMENTS: dict[str, tuple[str, tuple[str, ...], str]] = {
    "namespace": ("", (), "Namespace of all nodes; empty for none."),
    "config": (
        "small_uav",
        (),
        "Configuration: name of one of the package (paper, small_uav, px4_uav, jsbsim_uav), or "
        "path of a YAML file.",
    ),
    "scenario": (
        "",
        (),
        "Wind, gusts or target laid over the configuration: name of a scenario of the package, or "
        "path of a YAML file.",
    ),
    "vehicle": (
        "simulator",
        ("simulator", "autopilot", "none"),
        "What flies: the simulator, a real autopilot through autopilot_link, or what another node "
        "publishes as uav/odometry.",
    ),
    "connection": (
        "",
        (),
        "Where the autopilot of a single aircraft is, such as udpin:0.0.0.0:14550; empty for what "
        "the configuration says.",
    ),
    "target": (
        "true",
        SWITCH,
        "Start target_publisher, for each aircraft one; false where a tracker publishes the "
        "target.",
    ),
    "autostart": (
        "true",
        SWITCH,
        "Configure and activate the controller; false where a lifecycle manager does.",
    ),
    "use_sim_time": (
        "false",
        SWITCH,
        "Follow /clock, which the first simulator drives, instead of the wall's clock.",
    ),
    "speed": ("1.0", (), "Simulated over wall time, where the simulator drives /clock."),
}
ONE_ARGUMENTS = {
    **AIRCRAFT_ARGUMENTS,
    "controller": ("true", SWITCH, "Start nmpc_controller."),
    "publish_clock": (
        "",
        ("", *SWITCH),
        "Let this simulator drive /clock, as one node alone may; empty for what use_sim_time says.",
    ),
    "initial_position": (
        "",
        (),
        "Where the simulated aircraft starts, x, y, z in map in [m], as 600, 0, 100; empty for "
        "what the configuration says.",
    ),
    "initial_heading": (
        "",
        (),
        "Where it heads then, counter-clockwise from East, in [rad]; empty for what the "
        "configuration says.",
    ),
}
FLEET_ARGUMENTS = {
    "aircraft": (
        "1",
        (),
        "How many, simulated. With more than one, each has a namespace uav1, uav2 and so on.",
    ),
    **AIRCRAFT_ARGUMENTS,
    "rviz": ("false", SWITCH, "Start RViz on all aircraft."),
    "rviz_config": (
        "",
        (),
        "Configuration of RViz; empty for that of the package, for these namespaces.",
    ),
    "record": (
        "false",
        SWITCH,
        "Record every topic of the package as an MCAP bag with `ros2 bag record`.",
    ),
    "bag": ("", (), "Folder of the bag, which must not exist; empty for one named by the time."),
}


class Start(NamedTuple):
    """Where a simulated aircraft starts.

    Attributes:
        position: (x, y, z) in ``map`` in [m].
        heading: Counter-clockwise from East in [rad].
    """

    position: tuple[float, float, float]
    heading: float


def described(
    arguments: Mapping[str, tuple[str, tuple[str, ...], str]],
    act: Callable[[dict[str, str]], list[Any]],
) -> Any:
    """A launch description that declares arguments and does something with what they are.

    Args:
        arguments: By name: default, what is allowed, meaning.
        act: From the arguments' values to its actions.
    """
    from launch import LaunchDescription
    from launch.actions import DeclareLaunchArgument, OpaqueFunction
    from launch.substitutions import LaunchConfiguration

    declared = [
        DeclareLaunchArgument(
            name, default_value=default, choices=list(allowed) or None, description=meaning
        )
        for name, (default, allowed, meaning) in arguments.items()
    ]

    def acted(context: Any) -> list[Any]:
        return act({n: LaunchConfiguration(n).perform(context) for n in arguments})

    return LaunchDescription([*declared, OpaqueFunction(function=acted)])


def namespaces(namespace: str, count: str) -> tuple[str, ...]:
    """Namespaces of the aircraft.

    Args:
        namespace: Of everything; empty for none.
        count: How many aircraft, as it stands on a command line.

    Returns:
        The namespace itself for a single aircraft; ``uav1``, ``uav2`` and so on below it for more.

    Raises:
        ParameterError: No such number, or no name that ROS takes.
    """
    if not count.isdecimal() or not 1 <= int(count) <= MOST:
        raise ParameterError(
            f"argument 'aircraft' is {count!r}, must be a whole number from 1 to {MOST}"
        )
    if not NAMESPACE.fullmatch(namespace):
        raise ParameterError(
            f"argument 'namespace' is {namespace!r}, must be empty or names of letters, digits and "
            "underscores with slashes between them"
        )
    if int(count) == 1:
        return (namespace,)
    return tuple("/".join(filter(None, (namespace, f"uav{k + 1}"))) for k in range(int(count)))


def starts(configuration: Configuration, count: int) -> tuple[Start, ...]:
    """Where aircraft start: that of the configuration first, the others turned about the target.

    Args:
        configuration: With start and target of one of them.
        count: How many.
    """
    x, y, z = configuration.simulator.initial_position
    centre_x, centre_y, _ = configuration.target.position
    found = []
    for k in range(count):
        turn = 2.0 * math.pi * k / count
        cosine, sine = math.cos(turn), math.sin(turn)
        east, north = x - centre_x, y - centre_y
        heading = math.remainder(configuration.simulator.initial_heading + turn, 2.0 * math.pi)
        position = (
            centre_x + cosine * east - sine * north,
            centre_y + sine * east + cosine * north,
            z,
        )
        found.append(Start(position, heading))
    return tuple(found)


def recorded_topics(spaces: Sequence[str]) -> list[str]:
    """Absolute names of every topic of the package, and of the transforms.

    Args:
        spaces: Namespaces of the aircraft.
    """
    from uav_tracking_mpc.nodes.topics import ALL

    names = [absolute(space, topic.name) for space in spaces for topic in ALL]
    return [*dict.fromkeys(names), *TRANSFORMS]


def rviz_view(template: str, spaces: Sequence[str]) -> str:
    """A configuration of RViz with one group of displays for each aircraft.

    Args:
        template: The configuration for a single aircraft without a namespace.
        spaces: Namespaces of the aircraft.
    """
    view = yaml.safe_load(template)
    displays = view["Visualization Manager"]["Displays"]
    (group,) = (display for display in displays if display["Name"] == AIRCRAFT)
    place = displays.index(group)
    displays[place : place + 1] = [_group(group, space) for space in spaces]
    return yaml.safe_dump(view, sort_keys=False)


def _group(group: dict[str, Any], space: str) -> dict[str, Any]:
    named = copy.deepcopy(group)
    named["Name"] = space or AIRCRAFT
    for display in named["Displays"]:
        for value in display.values():
            if isinstance(value, dict) and str(value.get("Value", "")).startswith("/"):
                value["Value"] = absolute(space, value["Value"].lstrip("/"))
    return named


def absolute(space: str, name: str) -> str:
    """Absolute name of a topic in a namespace.

    Args:
        space: The namespace; empty for none.
        name: Of the topic; one that is absolute stays as it is.
    """
    if name.startswith("/"):
        return name
    return "/" + "/".join(part for part in (space.strip("/"), name) if part)
