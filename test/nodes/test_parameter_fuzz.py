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

"""Absurd parameters, from the command line and from YAML: a node starts, or says why not.

They go through the nodes' own front door, `run`, in this process: one parameter of each type in the
suite, every parameter in its long form. A few do so in processes of their own, for what a process
alone can show.
"""

import gc

import pytest
import rclpy
from node_flight import NODES
from node_harness import ending
from processes import fatal_words
from rclpy.node import Node

from uav_tracking_mpc.nodes.ros.declared_parameters import declare_parameters
from uav_tracking_mpc.nodes.target_publisher import TargetPublisher
from uav_tracking_mpc.parameters.specification import specifications
from uav_tracking_mpc.settings.configuration import SECTIONS

pytestmark = pytest.mark.nodes
ABSURD = (
    ".nan",
    "-.inf",
    "1e300",
    "-1e300",
    "1e999",
    "0",
    "-1",
    "9223372036854775807",
    "99999999999999999999",
    "true",
    "banana",
    "''",
    "~",
    "[]",
    "[.nan, 1.0, 1.0]",
    "[1.0, 1.0, 1.0, 1.0, 1.0, 1.0e300]",
    "[true, banana]",
    "{a: 1}",
    "[",
    "x" * 5000,
)


@pytest.fixture
def starts(run_here):
    """Whether a node starts, or ends with code 2 and one line that says why."""

    def starts(name, create, *arguments):
        code, output = run_here(name, lambda: ending(create()), "--ros-args", *arguments)
        if code == 0:
            assert "[FATAL]" not in output
            assert "Traceback" not in output
            return True
        assert len(fatal_words(name, code, output)) > 10
        return False

    return starts


def bare(name):
    """A node that has the parameters and nothing else: quick to make."""
    node = Node(name)
    declare_parameters(node, SECTIONS[name])
    return node


def of_each_type(node, count):
    """The first parameters of each type that a node has."""
    found = {}
    for known in specifications(SECTIONS[node]):
        found.setdefault((type(known.default), bool(known.choices)), []).append(known)
    return [known for alike in found.values() for known in alike[:count]]


@pytest.mark.parametrize("count", [1, pytest.param(None, marks=pytest.mark.long)])
@pytest.mark.parametrize("node", NODES)
def test_parameters_from_the_command_line(node, count, starts):
    started = [
        starts(node, lambda: bare(node), "-p", f"{known.name}:={text}")
        for known in of_each_type(node, count)
        for text in ABSURD
    ]
    assert any(started)  # some of it is allowed


@pytest.mark.parametrize(
    "node",
    [
        pytest.param(node, marks=() if node == "nmpc_controller" else pytest.mark.long)
        for node in NODES
    ],
)
def test_every_type_of_parameter_from_yaml(node, starts, tmp_path):
    file = tmp_path / "parameters.yaml"
    for known in of_each_type(node, 1):
        for text in ABSURD:
            file.write_text(f"/**/{node}:\n  ros__parameters:\n    {known.name}: {text}\n")
            starts(node, lambda: bare(node), "--params-file", str(file))


@pytest.mark.parametrize(
    "text",
    [
        "",
        "banana",
        "[1, 2, 3]",
        "/**:\n  ros__parameters:\n",
        "/**:\n  ros__parameters: 3\n",
        "/**:\n  parameters: {range: 3.0}\n",
        "/**: &a\n  ros__parameters: *a\n",
        "\t\x00\x01",
        "/**:\n  ros__parameters: {" + "a: {" * 50 + "}" * 51,
    ],
)
def test_files_that_are_no_configuration(text, starts, tmp_path):
    file = tmp_path / "parameters.yaml"
    file.write_text(text)
    starts("target_publisher", TargetPublisher, "--params-file", str(file))


# What shapes the optimal control problem is compiled anew for every value: ten seconds each.
COMPILED = (
    "horizon",
    "control_rate",
    "weights",
    "terminal",
    "scheme",
    "model",
    "direction",
    "airspeed",
)


def extremes(node, count):
    """Both ends of what each number may be: allowed one by one, if not together."""
    for known in of_each_type(node, count):
        if node == "nmpc_controller" and any(word in known.name for word in COMPILED):
            continue
        for value in (known.lower, known.upper):
            if value is not None:
                number = value
                if isinstance(known.default, tuple):
                    number = [float(value)] * (known.size or known.multiple)
                yield f"{known.name}:={number!r}"
        for choice in known.choices:
            yield f"{known.name}:={choice}"


@pytest.mark.parametrize("count", [2, pytest.param(None, marks=pytest.mark.long)])
@pytest.mark.parametrize("node", NODES)
def test_whole_nodes_start_with_what_is_just_allowed_or_say_why_not(node, count, starts):
    def create():
        gc.collect()  # the one before, which may not have been made to its end
        return NODES[node]()

    started = [starts(node, create, "-p", each) for each in extremes(node, count)]
    assert any(started)


def test_no_context_is_left_behind():
    assert not rclpy.ok()
