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

"""One aircraft or several that circle a target, with RViz and a recording if asked for.

::

    ros2 launch uav_tracking_mpc tracking.launch.py rviz:=true
    ros2 launch uav_tracking_mpc tracking.launch.py aircraft:=2 use_sim_time:=true speed:=5.0

What concerns one aircraft is in aircraft.launch.py, which can be included on its own.
"""

import tempfile
from pathlib import Path

from launch import LaunchDescription
from launch.actions import (
    DeclareLaunchArgument,
    ExecuteProcess,
    IncludeLaunchDescription,
    OpaqueFunction,
)
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

from uav_tracking_mpc.launch.fleet import namespaces, recorded_topics, rviz_view, starts
from uav_tracking_mpc.parameters.specification import ParameterError
from uav_tracking_mpc.settings.configuration import load_configuration

SHARE = Path(__file__).parents[1]
SWITCH = ("true", "false")
PASSED = ("config", "vehicle", "connection", "target", "autostart", "use_sim_time", "speed")
ARGUMENTS = (
    DeclareLaunchArgument(
        "aircraft",
        default_value="1",
        description="How many, simulated. With more than one, each has a namespace uav1, uav2 and "
        "so on.",
    ),
    DeclareLaunchArgument(
        "namespace", default_value="", description="Namespace of everything; empty for none."
    ),
    DeclareLaunchArgument(
        "config",
        default_value="small_uav",
        description="Configuration: name of one of the package (paper, small_uav, px4_uav, "
        "jsbsim_uav), or path of a YAML file.",
    ),
    DeclareLaunchArgument(
        "scenario",
        default_value="",
        description="Wind, gusts or target laid over the configuration: name of a scenario of the "
        "package, or path of a YAML file.",
    ),
    DeclareLaunchArgument(
        "vehicle",
        default_value="simulator",
        choices=("simulator", "autopilot", "none"),
        description="What flies: the simulator, a real autopilot through autopilot_link, or what "
        "another node publishes as uav/odometry.",
    ),
    DeclareLaunchArgument(
        "connection",
        default_value="",
        description="Where the autopilot of a single aircraft is, such as udpin:0.0.0.0:14550; "
        "empty for what the configuration says.",
    ),
    DeclareLaunchArgument(
        "target",
        default_value="true",
        choices=SWITCH,
        description="Start a target_publisher for each aircraft; false where a tracker publishes "
        "the target.",
    ),
    DeclareLaunchArgument(
        "autostart",
        default_value="true",
        choices=SWITCH,
        description="Configure and activate the controllers; false where a lifecycle manager does.",
    ),
    DeclareLaunchArgument(
        "use_sim_time",
        default_value="false",
        choices=SWITCH,
        description="Follow /clock, which the first simulator drives, instead of the wall's clock.",
    ),
    DeclareLaunchArgument(
        "speed", default_value="1.0", description="Simulated over wall time, with use_sim_time."
    ),
    DeclareLaunchArgument(
        "rviz", default_value="false", choices=SWITCH, description="Start RViz on all aircraft."
    ),
    DeclareLaunchArgument(
        "rviz_config",
        default_value="",
        description="Configuration of RViz; empty for that of the package, for these namespaces.",
    ),
    DeclareLaunchArgument(
        "record",
        default_value="false",
        choices=SWITCH,
        description="Record every topic of the package as an MCAP bag with `ros2 bag record`.",
    ),
    DeclareLaunchArgument(
        "bag",
        default_value="",
        description="Folder of the bag, which must not exist; empty for one named by the time.",
    ),
)


def generate_launch_description() -> LaunchDescription:
    """Every aircraft, and what looks on."""
    return LaunchDescription([*ARGUMENTS, OpaqueFunction(function=_everything)])


def _everything(context):
    given = {
        argument.name: LaunchConfiguration(argument.name).perform(context) for argument in ARGUMENTS
    }
    spaces = namespaces(given["namespace"], given["aircraft"])
    if given["vehicle"] == "autopilot" and len(spaces) > 1:
        raise ParameterError(
            f"argument 'aircraft' is '{len(spaces)}', must be 1 with vehicle:=autopilot: all would "
            "have one connection; include aircraft.launch.py for each, with one of its own"
        )
    actions = _fleet(given, spaces)
    if given["rviz"] == "true":
        actions.append(_rviz(given, spaces))
    if given["record"] == "true":
        actions.append(_recording(given, spaces))
    return actions


def _fleet(given, spaces):
    """One inclusion an aircraft; they start evenly about the target, so as not to meet at once."""
    configuration = load_configuration(given["config"], scenario=given["scenario"] or None)
    return [
        IncludeLaunchDescription(
            PythonLaunchDescriptionSource(str(SHARE / "launch" / "aircraft.launch.py")),
            launch_arguments={
                **{name: given[name] for name in PASSED},
                "scenario": given["scenario"],
                "namespace": namespace,
                "publish_clock": given["use_sim_time"] if namespace == spaces[0] else "false",
                "initial_position": ", ".join(map(repr, start.position)),
                "initial_heading": repr(start.heading),
            }.items(),
        )
        for namespace, start in zip(spaces, starts(configuration, len(spaces)), strict=True)
    ]


def _rviz(given, spaces):
    file = given["rviz_config"]
    if not file:
        # RViz reads the file when it has started, and writes to it when people save their view.
        template = (SHARE / "rviz" / "tracking.rviz").read_text(encoding="utf-8")
        with tempfile.NamedTemporaryFile("w", suffix=".rviz", delete=False) as written:
            written.write(rviz_view(template, spaces))
        file = written.name
    return Node(
        package="rviz2",
        executable="rviz2",
        name="rviz2",
        arguments=["-d", file],
        parameters=[{"use_sim_time": given["use_sim_time"] == "true"}],
        output="screen",
    )


def _recording(given, spaces):
    command = ["ros2", "bag", "record", "--storage", "mcap"]
    command += ["--storage-preset-profile", "zstd_fast", "--disable-keyboard-controls"]
    if given["bag"]:
        command += ["--output", given["bag"]]
    return ExecuteProcess(cmd=[*command, "--topics", *recorded_topics(spaces)], output="screen")
