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

"""``engage`` and ``set`` of a flight that runs: what the nodes do, and what is refused."""

import pytest
from processes import DOMAIN
from rclpy.node import Node
from std_srvs.srv import SetBool

from uav_tracking_mpc.cli import engage
from uav_tracking_mpc.cli.main import main
from uav_tracking_mpc.nodes.ros.process import BackgroundNode
from uav_tracking_mpc.nodes.target_publisher import TargetPublisher
from uav_tracking_mpc.nodes.uav_simulator import UavSimulator

pytestmark = pytest.mark.nodes
pytest.importorskip("rclpy")


class Switch(Node):
    """A node with the service engage, which may refuse."""

    def __init__(self, name, refusal="", **options):
        super().__init__(name, **options)
        self.asked, self._refusal = [], refusal
        self.create_service(SetBool, "~/engage", self._on_request)

    def _on_request(self, request, response):
        self.asked.append(request.data)
        response.success, response.message = not self._refusal, self._refusal
        return response


@pytest.fixture
def fly():
    """Starts nodes in the domain of the test."""
    spun = []

    def start(create):
        spun.append(BackgroundNode(create, int(DOMAIN)))
        return spun[-1].node

    yield start
    for each in spun:
        each.close()


def ask(*words):
    return main([*words, "--domain-id", DOMAIN])


def test_parameters_are_set_together_or_refused_in_the_nodes_words(fly, capfd):
    target = fly(lambda context: TargetPublisher(context=context))
    simulator = fly(lambda context: UavSimulator(context=context))
    assert ask("set", "target_publisher.motion=circle", "target_publisher.speed=3",
               "uav_simulator.wind=[6, 0, 0]") == 0  # fmt: skip
    assert (target.parameters.motion, target.parameters.speed) == ("circle", 3.0)
    assert simulator.parameters.wind == (6.0, 0.0, 0.0)
    assert "target_publisher.motion: circle" in capfd.readouterr().out
    assert ask("set", "target_publisher.motion=line", "target_publisher.speed=-3") == 2
    assert "target_publisher: parameter 'speed' is -3" in capfd.readouterr().err
    assert target.parameters.motion == "circle"


def test_the_aircraft_of_a_namespace_is_asked(fly):
    red, blue = (
        fly(lambda context, name=name: TargetPublisher(context=context, namespace=name))
        for name in ("red", "blue")
    )
    assert ask("set", "target_publisher.noise=2.5", "--namespace", "blue") == 0
    assert (red.parameters.noise, blue.parameters.noise) == (0.0, 2.5)


@pytest.mark.parametrize(
    ("assignment", "words"),
    [
        ("pilot.range=3", "must be SECTION.PARAMETER=VALUE with SECTION one of"),
        ("mission.speed=3", "must be SECTION.PARAMETER=VALUE with SECTION one of"),
        ("target_publisher.noise", "must be SECTION.PARAMETER=VALUE"),
        ("target_publisher.nois=2", "has no parameter 'nois' (did you mean 'noise'?)"),
        ("target_publisher.noise={a: 1}", "target_publisher: "),
        ("target_publisher.rate=3", "read-only"),
    ],
)
def test_what_cannot_be_set_is_refused(assignment, words, fly, capfd):
    fly(lambda context: TargetPublisher(context=context))
    assert ask("set", assignment) == 2
    assert words in capfd.readouterr().err


def test_a_simulated_flight_is_engaged_and_disengaged(fly, capfd):
    controller = fly(lambda context: Switch("nmpc_controller", context=context))
    fly(lambda context: UavSimulator(context=context))
    assert ask("engage", "--off") == ask("engage") == 0
    assert controller.asked == [False, True]
    assert "nmpc_controller/engage: on" in capfd.readouterr().out


def test_a_real_autopilot_is_engaged_behind_the_controller_and_let_go_alone(fly):
    link = fly(lambda context: Switch("autopilot_link", context=context))
    controller = fly(lambda context: Switch("nmpc_controller", context=context))
    assert ask("engage") == ask("engage", "--off") == 0
    assert controller.asked == [True]
    assert link.asked == [True, False]


def test_a_refusal_is_told_in_the_nodes_words(fly, capfd):
    fly(lambda context: Switch("nmpc_controller", "not active", context=context))
    fly(lambda context: UavSimulator(context=context))
    assert ask("engage") == 2
    assert "nmpc_controller/engage: not active" in capfd.readouterr().err


@pytest.mark.parametrize("words", [["engage"], ["set", "nmpc_controller.range=350"]])
def test_without_a_flight_it_says_where_it_looked(words, capfd, monkeypatch):
    monkeypatch.setattr(engage, "APPEARANCE", 0.2)
    assert ask(*words) == 1
    errors = capfd.readouterr().err
    assert "nmpc_controller is not there" in errors
    assert f"of ROS domain {DOMAIN}" in errors


@pytest.mark.parametrize(
    ("words", "namespace"),
    [([], "/"), (["--namespace", "red"], "/red"), (["--namespace", "/fleet/red/"], "/fleet/red")],
)
def test_it_watches_a_namespace(words, namespace, monkeypatch):
    given = []

    def run(name, create, arguments):
        given.extend([name, *arguments])
        return 0

    monkeypatch.setattr("uav_tracking_mpc.nodes.ros.process.run", run)
    assert main(["monitor", *words]) == 0
    assert given == ["monitor", "--ros-args", "-r", f"__ns:={namespace}"]
