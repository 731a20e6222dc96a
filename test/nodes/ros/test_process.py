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

from unittest import mock

import pytest
import yaml
from builtin_interfaces.msg import Time
from node_flight import NODES
from node_harness import ending
from processes import INTERRUPT, TERMINATE, fatal_words, run_node
from rclpy.clock import Clock as RosClock
from rclpy.clock import ClockType
from rclpy.node import Node
from rclpy.parameter import Parameter
from rosgraph_msgs.msg import Clock

from uav_tracking_mpc.nodes.monitor import Monitor
from uav_tracking_mpc.nodes.ros.node_reference import HEARD, SERVICES, help_text, sent
from uav_tracking_mpc.nodes.ros.process import refusal, run
from uav_tracking_mpc.nodes.target_publisher import TargetPublisher
from uav_tracking_mpc.parameters.specification import specifications
from uav_tracking_mpc.settings.configuration import SECTIONS

pytestmark = pytest.mark.nodes


FIRST_WORDS = {
    "uav_simulator": "waiting for the first command",
    "target_publisher": "target is stationary",
    "nmpc_controller": "orbit of 150 m",
    "autopilot_link": "ardupilot: no aircraft",
}


@pytest.mark.parametrize(("node", "stop"), [*zip(NODES, (INTERRUPT, TERMINATE) * 2, strict=True)])
def test_signals_end_a_node_cleanly(node, stop):
    code, output = run_node(node, stop=stop, after=FIRST_WORDS[node])
    assert code == 0, output
    assert "Traceback" not in output


class NegativeTime(Node):
    """Hears its own clock, of negative and of sound times, until it has heard a sound one."""

    refusal = ""

    def __init__(self):
        simulated = Parameter("use_sim_time", value=True)
        super().__init__("negative_time", parameter_overrides=[simulated])
        self.log = self.get_logger = mock.Mock()
        self.time, self.sender = -3, self.create_publisher(Clock, "/clock", 10)
        steady = RosClock(clock_type=ClockType.STEADY_TIME)
        self.create_timer(0.05, self._tick, clock=steady)

    def _tick(self):
        if self.sender.get_subscription_count() == 0:
            return
        if self.get_clock().now().nanoseconds > 0:
            self.refusal = "heard"
        self.sender.publish(Clock(clock=Time(sec=self.time)))
        self.time += 1


def test_negative_simulated_time_is_left_out_with_a_warning(monkeypatch, capfd):
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    node = []
    assert run("negative_time", lambda: node.append(NegativeTime()) or node[0], []) == 2
    assert "heard" in capfd.readouterr().err
    warned = [call.args[0] for call in node[0].log().warning.call_args_list]
    assert "/clock: the time is -3 s, must be at least 0: it is left out" in warned


REFUSED = [  # node, arguments of ROS, what the line says
    ("nmpc_controller", ["-p", "range:=far"], "parameter 'range' is 'far'"),
    ("nmpc_controller", ["-p", "range:=1e999"], "parameter 'range' is '1e999'"),
    ("nmpc_controller", ["-p", "state_weights:=[]"], "a list of 5 numbers"),
    ("nmpc_controller", ["-p", "state_weights:=[.nan, 1.0, 1.0, 1.0, 1.0]"], "'state_weights'"),
    ("nmpc_controller", ["-p", "range:=40.0"], "range is 40.0 m"),
    ("nmpc_controller", ["-p", "horizon:=0"], "'horizon' is 0, must be an integer from 1 to 200"),
    ("nmpc_controller", ["-p", "airspeed:=.nan"], "'airspeed' is nan"),
    ("nmpc_controller", ["-p", "map_frame:=/map"], "'map_frame' is '/map', must be a frame"),
    ("uav_simulator", ["-p", "speed_max:=-1.0"], "parameter 'speed_max' is -1.0"),
    ("uav_simulator", ["-p", "initial_position:=[]"], "'initial_position'"),
    ("uav_simulator", ["-p", "publish_clock:=banana"], "'publish_clock' is 'banana'"),
    ("uav_simulator", ["--params-file", "/nowhere.yaml"], "/nowhere.yaml"),
    ("uav_simulator", ["-p", "initial_speed:=50.0"], "'initial_speed' is 50.0"),
    ("uav_simulator", ["-p", "map_frame:=/map"], "'map_frame' is '/map', must be a frame"),
    ("uav_simulator", ["-p", "plant:=balloon"], "'plant' is 'balloon', must be one of euler, held"),
    ("uav_simulator", ["-p", "plant:=nowhere.py:Balloon"], "'plant': there is no file"),
    (
        "uav_simulator",
        ["-p", "plant:=euler", "-p", "initial_position:=[0.0, 0.0, 9.0]"],
        "'plant': at 0 s the range",
    ),
    ("autopilot_link", ["-p", "connection:=udpin:nowhere"], "must be udpin:HOST:PORT"),
    ("autopilot_link", ["-p", "link:=balloon"], "'link' is 'balloon', must be one of"),
    ("autopilot_link", ["-p", "link:=nowhere.py:Balloon"], "there is no file"),
    ("autopilot_link", ["-p", "origin:=[1.0, 2.0]"], "'origin'"),
    ("autopilot_link", ["-p", "origin:=[95.0, 8.5, 400.0]"], "latitude within 90 deg"),
    ("autopilot_link", ["-p", "origin:=[1.0, 2.0, 3.0, 1.0, 2.0, 3.0]"], "latitude within 90"),
    ("target_publisher", ["-p", "rate:=.nan"], "parameter 'rate' is nan"),
    ("target_publisher", ["-p", "nonsense"], "Couldn't parse parameter override"),
    ("target_publisher", ["-p", "seed:=99999999999999999999"], "'seed'"),
    ("target_publisher", ["-p", "motion:={a: 1}"], "motion"),
    ("target_publisher", ["-p", "motion:=hop"], "must be one of circle, jump, line"),
    ("target_publisher", ["-p", "noise:=much"], "'noise' is 'much'"),
    ("target_publisher", ["-p", "map_frame:=/map"], "'map_frame' is '/map', must be a frame"),
    (
        "target_publisher",
        ["-p", "qos_overrides./target/position.publisher.reliability:=perhaps"],
        "is 'perhaps', must be one of",
    ),
]


@pytest.mark.parametrize(("node", "arguments", "words"), REFUSED)
def test_bad_parameters_end_in_one_fatal_line_and_code_2(run_here, node, arguments, words):
    result = run_here(node, NODES[node], "--ros-args", *arguments)
    assert words in fatal_words(node, *result)


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
def test_a_node_lets_go_of_what_it_holds_whatever_ends_it(refused, monkeypatch, run_here):
    monkeypatch.setattr(Failing, "finished", False)
    if refused:
        assert fatal_words("failing", *run_here("failing", lambda: Failing(refused))) == refused
    else:
        with pytest.raises(LookupError, match="a mistake"):
            run_here("failing", lambda: Failing(refused))
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


@pytest.mark.parametrize(
    ("arguments", "variables", "words"),
    [
        (["--ros-args", "--bogus"], {}, "arguments that ROS does not know: '--bogus'"),
        (
            ["--params-file", "small_uav.yaml"],
            {},
            "write: target_publisher --ros-args --params-file small_uav.yaml",
        ),
        ([], {"ROS_DOMAIN_ID": "300"}, "ROS_DOMAIN_ID is '300', must be an integer from 0 to 232"),
        ([], {"ROS_SECURITY_ENABLE": "true"}, "which needs ROS_SECURITY_KEYSTORE"),
    ],
)
def test_what_ros_does_not_start_with_is_said_in_words(
    arguments, variables, words, monkeypatch, tmp_path, run_here
):
    (tmp_path / "enclaves").mkdir()  # a keystore without keys
    variables |= {"ROS_SECURITY_STRATEGY": "Enforce", "ROS_SECURITY_KEYSTORE": str(tmp_path)}
    for name, value in variables.items():
        monkeypatch.setenv(name, value)
    result = run_here("target_publisher", TargetPublisher, *arguments)
    assert words in fatal_words("target_publisher", *result)


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
def test_a_parameter_file_without_effect_is_warned_of(section, rate, warned, tmp_path, run_here):
    file = tmp_path / "parameters.yaml"
    file.write_text(f"{section}: {{ros__parameters: {{rate: 7.0}}}}{'}' * section.count('{')}")
    made = []

    def make():
        made.append(ending(TargetPublisher()))
        return made[0]

    arguments = ("--ros-args", "--params-file", str(file), "-r", "__ns:=/red")
    code, log = run_here("target_publisher", make, *arguments)
    assert code == 0
    assert (VAIN in log) == warned
    assert made[0].parameters.rate == rate


@pytest.mark.parametrize("more", ["", "    noise: !metres 0.5\n"])
def test_a_parameter_file_that_ros_reads_is_obeyed(more, tmp_path, run_here):
    """As ``ros2 launch`` writes the arrays of a launch file, and with a tag that ROS skips."""
    file = tmp_path / "parameters.yaml"
    values = {"position": (5.0, 6.0, 0.0), "rate": 7.0}
    written = yaml.dump({"/**": {"ros__parameters": values}})
    assert "!!python/tuple" in written
    file.write_text(written + more)
    made = []

    def make():
        made.append(ending(TargetPublisher()))
        return made[0]

    code, log = run_here("target_publisher", make, "--ros-args", "--params-file", str(file))
    assert code == 0, log
    assert VAIN not in log
    assert made[0].parameters.rate == 7.0
    assert list(made[0].parameters.position) == [5.0, 6.0, 0.0]
    assert made[0].parameters.noise == (0.5 if more else 0.0)


@pytest.mark.parametrize("name", HEARD)
def test_help_says_what_the_node_is_for_and_ends_with_code_0(name, run_here):
    code, output = run_here(name, {**NODES, "monitor": Monitor}[name], "--help")
    assert code == 0, output
    assert f"usage: ros2 run uav_tracking_mpc {name}" in output
    assert "--params-file FILE" in output
    assert "/diagnostics (diagnostic_msgs/msg/DiagnosticArray)" in output
    for item in specifications(SECTIONS[name]) if name in SECTIONS else ():
        assert f"  {item.name} (" in output


@pytest.mark.parametrize(
    ("name", "kind", "parameters"),
    [
        ("uav_simulator", NODES["uav_simulator"], {"publish_clock": True}),
        ("target_publisher", NODES["target_publisher"], {}),
        ("nmpc_controller", NODES["nmpc_controller"], {}),
        ("monitor", Monitor, {}),
    ],
)
def test_its_topics_are_those_of_the_real_node(nodes, name, kind, parameters):
    node = nodes.add(kind, **parameters)
    heard, told = (
        {end.topic_name.lstrip("/") for end in ends} - {"rosout", "parameter_events"}
        for ends in (node.subscriptions, node.publishers)
    )
    assert {topic.name.lstrip("/") for topic in HEARD[name]} == heard
    lifecycle = {topic for topic in told if topic.endswith("transition_event")}
    assert {topic.name.lstrip("/") for topic in sent(name)} - {"rosout"} == told - lifecycle


def test_services_are_named():
    for name, words in SERVICES.items():
        for line in words:
            assert line.split()[0] in help_text(name, "")
