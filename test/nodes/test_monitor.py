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

"""The live table: whose flight it shows, which others there are, and which node is silent."""

import io

import pytest
import rclpy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rclpy.signals import SignalHandlerOptions
from rich.console import Console

from uav_tracking_mpc.nodes import monitor as room
from uav_tracking_mpc.nodes.monitor import Monitor
from uav_tracking_mpc.nodes.topics import DIAGNOSTICS, ODOMETRY

pytestmark = pytest.mark.nodes


@pytest.fixture
def table():
    """Feeds statuses to a monitor and returns what it shows."""
    context = rclpy.Context()
    context.init(args=[])
    node = Monitor(Console(file=io.StringIO(), width=120), context=context)

    def show(*statuses):
        for name, aircraft, words in statuses:
            status = DiagnosticStatus(level=b"\x00", name=name, message=words, hardware_id=aircraft)
            node._on_message(DIAGNOSTICS, DiagnosticArray(status=[status]))
        console = Console(file=io.StringIO(), width=120)
        console.print(node.table())
        return console.file.getvalue()

    yield show
    node.finish()
    node.destroy_node()
    context.try_shutdown()


def test_it_shows_whose_a_node_is_and_that_it_is_silent(table, monkeypatch):
    now = [100.0]
    monkeypatch.setattr(room.time, "monotonic", lambda: now[0])
    said = table(
        ("red/nmpc_controller: status", "red", "tracking"),
        ("autopilot_link: status", "MAVLink system 7", "flown [by us]"),
    )
    assert "red/nmpc_controller" in said
    assert "MAVLink system 7" in said
    assert "flown [by us]" in said
    assert "silent" not in said
    now[0] += 2.0 * room.GONE
    said = table(("autopilot_link: status", "MAVLink system 7", "flown"))
    (silent,) = [line for line in said.splitlines() if "silent" in line]
    assert "red/nmpc_controller" in silent


@pytest.fixture
def ros():
    rclpy.init(args=[], signal_handler_options=SignalHandlerOptions.NO)
    yield
    rclpy.try_shutdown()


def shown(monitor):
    monitor._refresh()
    console = Console(file=io.StringIO(), width=160)
    console.print(monitor.table())
    return console.file.getvalue()


def told(monitor, *names):
    statuses = [DiagnosticStatus(name=f"{name}: status", message="fine") for name in names]
    monitor._on_message(DIAGNOSTICS, DiagnosticArray(status=statuses))


@pytest.mark.usefixtures("ros")
def test_alone_it_names_nobody_else():
    monitor = Monitor(Console(file=io.StringIO()))
    table = shown(monitor)
    monitor.finish()
    monitor.destroy_node()
    assert "other aircraft" not in table


@pytest.mark.usefixtures("ros")
def test_it_shows_its_namespace_and_names_the_other_aircraft():
    others = [rclpy.create_node("simulator", namespace=name) for name in ("red", "blue")]
    for node in others:
        node.create_publisher(ODOMETRY.type, ODOMETRY.name, ODOMETRY.qos)
    red = Monitor(Console(file=io.StringIO()), namespace="red")
    bare = Monitor(Console(file=io.StringIO()))
    for monitor in (red, bare):
        monitor._refresh()
        told(monitor, "red/nmpc_controller", "blue/nmpc_controller", "ground_station")
    red_table, bare_table = shown(red), shown(bare)
    for node in (red, bare):
        node.finish()
        node.destroy_node()
    for node in others:
        node.destroy_node()
    assert "flight of /red" in red_table
    assert "other aircraft in this domain: /blue; watch one with" in red_table
    assert "uav_tracking monitor --namespace /blue" in red_table
    assert "other aircraft in this domain: /blue, /red" in bare_table
    assert "red/nmpc_controller" in red_table
    assert "blue/nmpc_controller" not in red_table
    assert "nmpc_controller" not in bare_table
    assert "ground_station" in red_table
    assert "ground_station" in bare_table
