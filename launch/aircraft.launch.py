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

"""One aircraft in a namespace of its own: vehicle, target and controller, each optional.

Made to be included, once for each aircraft::

    IncludeLaunchDescription(
        PythonLaunchDescriptionSource(share / "launch" / "aircraft.launch.py"),
        launch_arguments={"namespace": "uav1", "config": "small_uav"}.items(),
    )
"""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

from uav_tracking_mpc.settings.configuration import configuration_folder, found

PACKAGE = "uav_tracking_mpc"
SWITCH = ("true", "false")
ARGUMENTS = (
    DeclareLaunchArgument(
        "namespace", default_value="", description="Namespace of all nodes; empty for none."
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
        description="Where the autopilot is, such as udpin:0.0.0.0:14550; empty for what the "
        "configuration says.",
    ),
    DeclareLaunchArgument(
        "target",
        default_value="true",
        choices=SWITCH,
        description="Start target_publisher; false where a tracker publishes the target.",
    ),
    DeclareLaunchArgument(
        "controller", default_value="true", choices=SWITCH, description="Start nmpc_controller."
    ),
    DeclareLaunchArgument(
        "autostart",
        default_value="true",
        choices=SWITCH,
        description="Configure and activate the controller; false where a lifecycle manager does.",
    ),
    DeclareLaunchArgument(
        "use_sim_time",
        default_value="false",
        choices=SWITCH,
        description="Follow /clock instead of the wall's clock.",
    ),
    DeclareLaunchArgument(
        "publish_clock",
        default_value=LaunchConfiguration("use_sim_time"),
        choices=SWITCH,
        description="Let this simulator drive /clock, as one node alone may; by default "
        "use_sim_time.",
    ),
    DeclareLaunchArgument(
        "speed", default_value="1.0", description="Simulated over wall time, with publish_clock."
    ),
    DeclareLaunchArgument(
        "initial_position",
        default_value="",
        description="Where the simulated aircraft starts, x, y, z in map in [m], as 600, 0, 100; "
        "empty for what the configuration says.",
    ),
    DeclareLaunchArgument(
        "initial_heading",
        default_value="",
        description="Where it heads then, counter-clockwise from East, in [rad]; empty for what "
        "the configuration says.",
    ),
)


def generate_launch_description() -> LaunchDescription:
    """Nodes of one aircraft."""
    return LaunchDescription([*ARGUMENTS, OpaqueFunction(function=_nodes)])


def _nodes(context):
    given = {
        argument.name: LaunchConfiguration(argument.name).perform(context) for argument in ARGUMENTS
    }
    folder = configuration_folder()
    files = [found("configuration", given["config"], folder)]
    if given["scenario"]:
        files.append(found("scenario", given["scenario"], folder / "scenarios"))
    time = {"use_sim_time": _true(given["use_sim_time"])}

    def node(name, parameters):
        return Node(
            package=PACKAGE,
            executable=name,
            name=name,
            namespace=given["namespace"],
            parameters=[*(str(file.resolve()) for file in files), {**time, **parameters}],
            output="screen",
        )

    nodes = []
    if given["vehicle"] == "simulator":
        nodes.append(node("uav_simulator", _simulator(given)))
    elif given["vehicle"] == "autopilot":
        connection = given["connection"]
        nodes.append(node("autopilot_link", {"connection": connection} if connection else {}))
    if _true(given["target"]):
        nodes.append(node("target_publisher", {}))
    if _true(given["controller"]):
        nodes.append(node("nmpc_controller", {"autostart": _true(given["autostart"])}))
    return nodes


def _simulator(given):
    """Its parameters: the vehicle is held until the first command, time until somebody listens."""
    parameters = {"start_on_command": True}
    if _true(given["publish_clock"]):
        parameters |= {"publish_clock": True, "wait_for_subscribers": 1}
        parameters["speed"] = float(given["speed"])
    if given["initial_position"]:
        parameters["initial_position"] = [
            float(value) for value in given["initial_position"].strip("[]").split(",")
        ]
    if given["initial_heading"]:
        parameters["initial_heading"] = float(given["initial_heading"])
    return parameters


def _true(value):
    return value.lower() == "true"
