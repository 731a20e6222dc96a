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

from launch_ros.actions import Node

from uav_tracking_mpc.launch.fleet import ONE_ARGUMENTS, described
from uav_tracking_mpc.parameters.specification import ParameterError
from uav_tracking_mpc.settings.configuration import configuration_folder, found

PACKAGE = "uav_tracking_mpc"


def generate_launch_description():
    """Nodes of one aircraft."""
    return described(ONE_ARGUMENTS, _nodes)


def _nodes(given):
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
    if _true(given["publish_clock"] or given["use_sim_time"]):
        parameters |= {"publish_clock": True, "wait_for_subscribers": 1}
        parameters["speed"] = _number("speed", given["speed"])
    if given["initial_position"]:
        parameters["initial_position"] = [
            _number("initial_position", value)
            for value in given["initial_position"].strip("[]").split(",")
        ]
    if given["initial_heading"]:
        parameters["initial_heading"] = _number("initial_heading", given["initial_heading"])
    return parameters


def _number(name, value):
    try:
        return float(value)
    except ValueError:
        raise ParameterError(f"argument {name!r} is {value!r}, must be a number") from None


def _true(value):
    return value.lower() == "true"
