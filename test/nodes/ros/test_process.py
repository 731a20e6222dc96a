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

"""Nodes as processes: exit codes, signals, --help."""

import importlib

import pytest
import rclpy
from processes import INTERRUPT, TERMINATE, run_node
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.signals import SignalHandlerOptions

from uav_tracking_mpc.nodes.ros.node_reference import HEARD, SERVICES, help_text, sent
from uav_tracking_mpc.nodes.ros.process import refusal, run
from uav_tracking_mpc.nodes.target_publisher import TargetPublisher
from uav_tracking_mpc.parameters.specification import specifications
from uav_tracking_mpc.settings.configuration import SECTIONS

pytestmark = pytest.mark.nodes


NODES = ("uav_simulator", "target_publisher", "nmpc_controller", "autopilot_link")
FIRST_WORDS = {
    "uav_simulator": "waiting for the first command",
    "target_publisher": "target is stationary",
    "nmpc_controller": "orbit of 150 m",
    "autopilot_link": "ardupilot: no aircraft",
}


@pytest.mark.parametrize("stop", [INTERRUPT, TERMINATE])
@pytest.mark.parametrize("node", NODES)
def test_signals_end_a_node_cleanly(node, stop):
    code, output = run_node(node, stop=stop, after=FIRST_WORDS[node])
    assert code == 0, output
    assert "Traceback" not in output


@pytest.mark.parametrize(
    ("node", "arguments", "words"),
    [
        ("nmpc_controller", ["-p", "range:=far"], "parameter 'range' is 'far'"),
        ("nmpc_controller", ["-p", "state_weights:=[]"], "a list of 5 numbers"),
        ("uav_simulator", ["-p", "speed_max:=-1.0"], "parameter 'speed_max' is -1.0"),
        ("autopilot_link", ["-p", "connection:=udpin:nowhere"], "must be udpin:HOST:PORT"),
        ("autopilot_link", ["-p", "link:=balloon"], "parameter 'link' is 'balloon'"),
        ("target_publisher", ["-p", "rate:=.nan"], "parameter 'rate' is nan"),
        ("target_publisher", ["-p", "nonsense"], "Couldn't parse parameter override"),
        ("uav_simulator", ["--params-file", "/nowhere.yaml"], "/nowhere.yaml"),
    ],
)
def test_bad_parameters_end_in_one_fatal_line_and_code_2(node, arguments, words):
    code, output = run_node(node, "--ros-args", *arguments)
    fatal = [line for line in output.splitlines() if line.startswith(f"[FATAL] [{node}]: ")]
    assert code == 2
    assert len(fatal) == 1
    assert words in fatal[0]
    assert "Traceback" not in output


class Failing(Node):
    """A node that gives up, or whose callback raises."""

    finished = False

    def __init__(self, refused):
        super().__init__("failing")
        self._refused, self.refusal = refused, ""
        self.create_timer(0.01, self._fail)

    def _fail(self):
        if not self._refused:
            raise LookupError("a mistake")
        self.refusal = self._refused

    def finish(self):
        Failing.finished = True


@pytest.mark.parametrize("refused", ["no such aircraft", ""])
def test_a_node_lets_go_of_what_it_holds_whatever_ends_it(refused, monkeypatch, capfd):
    monkeypatch.setattr(Failing, "finished", False)
    if refused:
        assert run("failing", lambda: Failing(refused), []) == 2
        assert f"[FATAL] [failing]: {refused}\n" in capfd.readouterr().err
    else:
        with pytest.raises(LookupError, match="a mistake"):
            run("failing", lambda: Failing(refused), [])
    assert Failing.finished


@pytest.mark.parametrize(
    ("arguments", "right"),
    [
        (["--params-file", "small_uav.yaml"], "--ros-args --params-file small_uav.yaml"),
        (["-p", "range:=350.0"], "--ros-args -p range:=350.0"),
        (["range:=350.0"], "--ros-args -p range:=350.0"),
        (["--range", "350"], "--ros-args -p NAME:=VALUE --params-file FILE"),
    ],
)
def test_arguments_that_ros_would_ignore_are_refused(arguments, right):
    words = refusal("nmpc_controller", arguments)
    assert "has no effect" in words
    assert words.endswith(f"write: nmpc_controller {right}")


def test_arguments_behind_ros_args_are_not_refused():
    assert refusal("monitor", []) == ""
    assert refusal("monitor", ["--ros-args", "-p", "use_sim_time:=true"]) == ""


def test_a_node_given_a_file_without_ros_args_ends_with_code_2():
    code, output = run_node("nmpc_controller", "--params-file", "small_uav.yaml")
    assert code == 2
    assert "[FATAL] [nmpc_controller]" in output
    assert "nmpc_controller --ros-args --params-file small_uav.yaml" in output


def test_misspelt_parameters_are_warned_of():
    code, output = run_node(
        "target_publisher", "--ros-args", "-p", "raet:=5.0", stop=INTERRUPT, after="stationary"
    )
    assert code == 0
    assert "parameter 'raet' is unknown and has no effect" in output


@pytest.mark.parametrize(
    ("arguments", "variables", "words"),
    [
        (["--ros-args", "--bogus"], {}, "arguments that ROS does not know: '--bogus'"),
        ([], {"ROS_DOMAIN_ID": "300"}, "ROS_DOMAIN_ID is '300', must be an integer from 0 to 232"),
        ([], {"ROS_SECURITY_ENABLE": "true"}, "which needs ROS_SECURITY_KEYSTORE"),
    ],
)
def test_what_ros_does_not_start_with_is_said_in_words(
    arguments, variables, words, monkeypatch, tmp_path, capfd
):
    (tmp_path / "enclaves").mkdir()  # a keystore without keys
    variables |= {"ROS_SECURITY_STRATEGY": "Enforce", "ROS_SECURITY_KEYSTORE": str(tmp_path)}
    for name, value in variables.items():
        monkeypatch.setenv(name, value)
    assert run("target_publisher", TargetPublisher, arguments) == 2
    fatal = [line for line in capfd.readouterr().err.splitlines() if "[FATAL]" in line]
    assert len(fatal) == 1
    assert words in fatal[0]


VAIN = "has no section for /red/target_publisher and no effect"


@pytest.mark.parametrize(
    ("section", "rate", "warned"),
    [
        ("target_publischer", 10.0, True),  # misspelt
        ("target_publisher", 10.0, True),  # in no namespace
        ("blue: {target_publisher", 10.0, True),
        ("/**/uav_simulator", 10.0, False),  # a neighbour's
        ("/**/target_publisher", 7.0, False),
        ("/*/target_publisher", 7.0, False),
        ("/**", 7.0, False),
        ("red: {target_publisher", 7.0, False),
    ],
)
def test_a_parameter_file_without_effect_is_warned_of(section, rate, warned, tmp_path, capfd):
    file = tmp_path / "parameters.yaml"
    file.write_text(f"{section}: {{ros__parameters: {{rate: 7.0}}}}{'}' * section.count('{')}")
    made = []

    class Ended(TargetPublisher):
        def __init__(self):
            super().__init__()
            made.append(self)

        @property
        def refusal(self):
            return "enough"

    arguments = ["--params-file", str(file), "-r", "__ns:=/red"]
    assert run("target_publisher", Ended, ["--ros-args", *arguments]) == 2
    log = capfd.readouterr().err
    assert (VAIN in log) == warned
    assert made[0].parameters.rate == rate


def test_a_configuration_serves_nodes_in_any_namespace(tmp_path):
    file = tmp_path / "configuration.yaml"
    file.write_text("/**/nmpc_controller: {ros__parameters: {range: 160.0}}")
    arguments = ["--params-file", str(file), "-r", "__ns:=/red"]
    code, output = run_node(
        "nmpc_controller", "--ros-args", *arguments, stop=INTERRUPT, after="orbit of 160 m"
    )
    assert code == 0
    assert "red.nmpc_controller" in output


CLASSES = {
    "uav_simulator": "UavSimulator",
    "target_publisher": "TargetPublisher",
    "nmpc_controller": "NmpcController",
    "monitor": "Monitor",
}


@pytest.mark.parametrize("name", HEARD)
def test_help_says_what_the_node_is_for_and_ends_with_code_0(name):
    code, output = run_node(name, "--help")
    assert code == 0, output
    assert f"usage: ros2 run uav_tracking_mpc {name}" in output
    assert "--params-file FILE" in output
    assert "/diagnostics (diagnostic_msgs/msg/DiagnosticArray)" in output
    for item in specifications(SECTIONS[name]) if name in SECTIONS else ():
        assert f"  {item.name} (" in output


@pytest.mark.parametrize(("name", "kind"), CLASSES.items())
def test_its_topics_are_those_of_the_real_node(name, kind):
    rclpy.init(args=[], signal_handler_options=SignalHandlerOptions.NO)
    more = {"publish_clock": True} if name == "uav_simulator" else {}
    overrides = [Parameter(key, value=value) for key, value in more.items()]
    node = getattr(importlib.import_module(f"uav_tracking_mpc.nodes.{name}"), kind)(
        parameter_overrides=overrides
    )
    try:
        own = {"/rosout", "/parameter_events"}
        heard = {subscription.topic_name for subscription in node.subscriptions} - own
        published = {publisher.topic_name for publisher in node.publishers} - own
        if name == "monitor":
            node.finish()
    finally:
        node.destroy_node()
        rclpy.try_shutdown()
    assert {topic.name.lstrip("/") for topic in HEARD[name]} == {t.lstrip("/") for t in heard}
    lifecycle = {t for t in published if t.endswith("transition_event")}
    told = {topic.name.lstrip("/") for topic in sent(name)} - {"rosout"}  # of rcl, not of rclpy
    assert told == {t.lstrip("/") for t in published - lifecycle}


def test_services_are_named():
    for name, words in SERVICES.items():
        for line in words:
            assert line.split()[0] in help_text(name, "")
