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

from launch.actions import ExecuteProcess, IncludeLaunchDescription
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch_ros.actions import Node

from uav_tracking_mpc.launch.fleet import (
    FLEET_ARGUMENTS,
    described,
    namespaces,
    recorded_topics,
    rviz_view,
    starts,
)
from uav_tracking_mpc.parameters.specification import ParameterError
from uav_tracking_mpc.settings.configuration import load_configuration

SHARE = Path(__file__).parents[1]
PASSED = ("config", "vehicle", "connection", "target", "autostart", "use_sim_time", "speed")


def generate_launch_description():
    """Every aircraft, and what looks on."""
    return described(FLEET_ARGUMENTS, _everything)


def _everything(given):
    spaces = namespaces(given["namespace"], given["aircraft"])
    if given["vehicle"] == "autopilot" and len(spaces) > 1:
        raise ParameterError(
            f"argument 'aircraft' is '{len(spaces)}', must be 1 with vehicle:=autopilot: all would "
            "have one connection; include aircraft.launch.py for each, with one of its own"
        )
    # RViz first: where it is not installed, launch fails there, and would leave nodes behind.
    actions = [_rviz(given, spaces)] if given["rviz"] == "true" else []
    actions += _fleet(given, spaces)
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
