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

"""The launch files start the right nodes, with parameters that they know, where they belong."""

import math
from itertools import pairwise
from pathlib import Path

import launch_stand_in
import pytest
import yaml
from launch_stand_in import ExecuteProcess, Node

from uav_tracking_mpc.launch.fleet import recorded_topics
from uav_tracking_mpc.parameters.specification import ParameterError, specifications
from uav_tracking_mpc.settings.configuration import (
    SECTIONS,
    configuration_folder,
    load_configuration,
    read_yaml,
)

FOLDER = Path(__file__).parents[2] / "launch"
TRACKING, AIRCRAFT = FOLDER / "tracking.launch.py", FOLDER / "aircraft.launch.py"
START = load_configuration("small_uav").simulator.initial_position


def started(path, **arguments):
    context = launch_stand_in.Context()
    context.launch_configurations.update(arguments)
    with launch_stand_in.stand_in():
        return launch_stand_in.started(launch_stand_in.loaded(path), context)


def nodes(path, **arguments):
    return {each.node_name: each for each in started(path, **arguments) if isinstance(each, Node)}


@pytest.mark.parametrize("path", [TRACKING, AIRCRAFT], ids=lambda path: path.stem)
def test_by_default_one_simulated_aircraft_flies_in_wall_time(path):
    found = nodes(path)
    assert set(found) == {"/uav_simulator", "/target_publisher", "/nmpc_controller"}
    for name, node in found.items():
        assert (node.node_package, f"/{node.node_executable}") == ("uav_tracking_mpc", name)
        assert node.files == [str(configuration_folder() / "small_uav.yaml")]
        assert node.values["use_sim_time"] is False
    assert found["/uav_simulator"].values["start_on_command"] is True
    assert "publish_clock" not in found["/uav_simulator"].values
    assert found["/nmpc_controller"].values["autostart"] is True


def test_aircraft_have_namespaces_and_starts_of_their_own_and_one_clock():
    found = nodes(TRACKING, aircraft="3", namespace="field", use_sim_time="true", speed="2.5")
    assert len(found) == 9
    simulators = [found[f"/field/uav{k}/uav_simulator"].values for k in (1, 2, 3)]
    assert [values.get("publish_clock", False) for values in simulators] == [True, False, False]
    assert simulators[0]["speed"] == 2.5
    assert all(node.values["use_sim_time"] is True for node in found.values())
    # Evenly about the target, which is at the origin; each heads as it did with respect to it.
    for k, values in enumerate(simulators):
        x, y, z = values["initial_position"]
        assert math.hypot(x, y) == pytest.approx(math.hypot(START[0], START[1]))
        assert z == START[2]
        bearing = math.atan2(y, x)
        assert math.remainder(bearing - 2.0 * math.pi * k / 3, 2.0 * math.pi) == pytest.approx(0.0)
        turned = values["initial_heading"] - bearing
        assert math.cos(turned) == pytest.approx(-1.0)  # towards the target


@pytest.mark.parametrize(
    ("arguments", "executables"),
    [
        ({"vehicle": "autopilot"}, {"autopilot_link", "target_publisher", "nmpc_controller"}),
        ({"vehicle": "none"}, {"target_publisher", "nmpc_controller"}),
        ({"target": "false"}, {"uav_simulator", "nmpc_controller"}),
        ({"controller": "false"}, {"uav_simulator", "target_publisher"}),
    ],
)
def test_what_is_there_already_is_left_out(arguments, executables):
    found = started(AIRCRAFT, **arguments)
    assert {node.node_executable for node in found} == executables


def test_an_autopilot_is_where_it_is_told_to_be():
    told = nodes(TRACKING, vehicle="autopilot", connection="udpin:0.0.0.0:14550")
    assert told["/autopilot_link"].values["connection"] == "udpin:0.0.0.0:14550"
    assert "connection" not in nodes(TRACKING, vehicle="autopilot")["/autopilot_link"].values


@pytest.mark.parametrize("connection", ["", "udpin:127.0.0.1:14550"])
def test_two_aircraft_with_one_autopilot_are_refused(connection):
    with pytest.raises(ParameterError, match="must be 1 with vehicle:=autopilot"):
        started(TRACKING, vehicle="autopilot", aircraft="2", connection=connection)


def test_a_lifecycle_manager_may_start_the_controller():
    found = nodes(TRACKING, autostart="false", namespace="uav")
    assert found["/uav/nmpc_controller"].values["autostart"] is False


def test_every_parameter_is_known_to_its_node():
    for arguments in ({}, {"vehicle": "autopilot", "connection": "udpin:127.0.0.1:14550"}):
        for node in nodes(TRACKING, use_sim_time="true", **arguments).values():
            kind = SECTIONS[node.node_executable].extended(node.values)
            known = {each.name for each in specifications(kind)}
            assert set(node.values) - {"use_sim_time"} <= known


def test_a_configuration_is_a_name_or_a_file_and_a_scenario_lies_over_it(tmp_path):
    own = tmp_path / "own.yaml"
    own.write_text(load_configuration("paper").yaml())
    for node in nodes(TRACKING, config=str(own), scenario="crosswind").values():
        scenario = str(configuration_folder() / "scenarios" / "crosswind.yaml")
        assert node.files == [str(own), scenario]
    with pytest.raises(ParameterError, match="configuration is 'nowhere', must be a file or one"):
        started(AIRCRAFT, config="nowhere")


@pytest.mark.parametrize("count", ["0", "21", "two", "-1", "1.5", ""])
def test_a_wrong_number_of_aircraft_is_refused(count):
    with pytest.raises(ParameterError, match="argument 'aircraft' is .* must be a whole number"):
        started(TRACKING, aircraft=count)


@pytest.mark.parametrize(
    ("name", "value"),
    [("speed", "fast"), ("initial_position", "600, x, 100"), ("initial_heading", "north")],
)
def test_what_is_no_number_is_refused_by_its_name(name, value):
    with pytest.raises(ParameterError, match=f"argument '{name}' is .* must be a number"):
        started(AIRCRAFT, use_sim_time="true", **{name: value})


@pytest.mark.parametrize("namespace", ["uav 1", "1uav", "uav//a", "uav-1", "~"])
def test_a_namespace_that_ros_does_not_take_is_refused(namespace):
    with pytest.raises(ParameterError, match="argument 'namespace' is"):
        started(TRACKING, namespace=namespace)


def test_every_topic_of_every_aircraft_is_recorded():
    (recording,) = (
        each
        for each in started(TRACKING, aircraft="2", record="true", bag="flight")
        if isinstance(each, ExecuteProcess)
    )
    command = recording.cmd
    assert command[:5] == ["ros2", "bag", "record", "--storage", "mcap"]
    assert command[command.index("--output") + 1] == "flight"
    topics = command[command.index("--topics") + 1 :]
    assert topics == recorded_topics(["uav1", "uav2"])
    assert {"/uav1/uav/odometry", "/uav2/uav/command", "/tf", "/tf_static"} <= set(topics)
    assert len(topics) == len(set(topics))


def test_rviz_shows_every_aircraft():
    view = nodes(TRACKING, aircraft="2", rviz="true", use_sim_time="true")["/rviz2"]
    assert view.values == {"use_sim_time": True}
    flag, file = view.arguments
    assert flag == "-d"
    written = yaml.safe_load(Path(file).read_text())
    Path(file).unlink()
    groups = [
        display["Name"]
        for display in written["Visualization Manager"]["Displays"]
        if display["Class"] == "rviz_common/Group"
    ]
    assert groups == ["uav1", "uav2"]
    assert nodes(TRACKING, rviz="true", rviz_config="my.rviz")["/rviz2"].arguments == [
        "-d",
        "my.rviz",
    ]


def test_nothing_flies_before_rviz_is_found():
    assert started(TRACKING, rviz="true")[0].node_package == "rviz2"


def test_every_argument_says_what_it_is_and_both_files_agree():
    def declared(path):
        with launch_stand_in.stand_in():
            entities = launch_stand_in.loaded(path).entities
        kind = launch_stand_in.DeclareLaunchArgument
        return {each.name: each for each in entities if isinstance(each, kind)}

    larger, smaller = declared(TRACKING), declared(AIRCRAFT)
    for argument in (*larger.values(), *smaller.values()):
        assert argument.description.endswith(".")
    for name in set(larger) & set(smaller):
        assert larger[name].default_value == smaller[name].default_value, name
        assert larger[name].choices == smaller[name].choices, name


def test_the_packages_of_ros_take_the_same_files():
    """Where they are installed; evaluated by themselves, up to the processes."""
    pytest.importorskip("launch_ros.actions")
    from launch.actions import ExecuteProcess as Process
    from launch.launch_context import LaunchContext
    from launch.launch_description_sources import PythonLaunchDescriptionSource

    def processes(entity, context):
        if isinstance(entity, Process):
            return [entity]
        return [found for each in entity.visit(context) or [] for found in processes(each, context)]

    context = LaunchContext()
    context.launch_configurations.update(aircraft="2", rviz="true", record="true")
    description = PythonLaunchDescriptionSource(str(TRACKING)).get_launch_description(context)
    names = []
    for process in processes(description, context):
        if type(process) is not Process:
            process._perform_substitutions(context)
            names.append(process.node_name)
            words = ["".join(getattr(part, "text", "") for part in word) for word in process.cmd]
            for flag, file in pairwise(words):
                if flag == "--params-file":
                    assert read_yaml(Path(file), "parameter file")
    viewer, *fleet = names
    assert fleet == [
        f"/uav{k}/{name}"
        for k in (1, 2)
        for name in ("uav_simulator", "target_publisher", "nmpc_controller")
    ]
    assert viewer.endswith("rviz2")
