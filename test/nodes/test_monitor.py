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

import functools
import io

import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rich.console import Console

from uav_tracking_mpc.nodes import monitor as room
from uav_tracking_mpc.nodes.monitor import Monitor
from uav_tracking_mpc.nodes.topics import DIAGNOSTICS, ODOMETRY

pytestmark = pytest.mark.nodes


def console():
    return Console(file=io.StringIO(), width=160)


@pytest.fixture
def add(nodes):
    """Adds a monitor in a namespace."""
    kind = functools.partial(Monitor, console())
    return lambda namespace="": nodes.add(kind, namespace=namespace)


def tell(monitor, name, aircraft="", words="fine"):
    """What a node of an aircraft says."""
    status = DiagnosticStatus(level=b"\x00", name=f"{name}: status", message=words)
    status.hardware_id = aircraft
    monitor._on_message(DIAGNOSTICS, DiagnosticArray(status=[status]))


def table(monitor):
    monitor._refresh()
    shown = console()
    shown.print(monitor.table())
    return shown.file.getvalue()


def test_it_shows_whose_a_node_is_and_that_it_is_silent(add, monkeypatch):
    now, monitor = [100.0], add()
    monkeypatch.setattr(room.time, "monotonic", lambda: now[0])
    tell(monitor, "red/nmpc_controller", "red", "tracking")
    tell(monitor, "autopilot_link", "MAVLink system 7", "flown [by us]")
    said = table(monitor)
    for words in ("red/nmpc_controller", "MAVLink system 7", "flown [by us]"):
        assert words in said
    assert "silent" not in said
    now[0] += 2.0 * room.GONE
    tell(monitor, "autopilot_link", "MAVLink system 7", "flown")
    (silent,) = [line for line in table(monitor).splitlines() if "silent" in line]
    assert "red/nmpc_controller" in silent


def test_alone_it_names_nobody_else(add):
    assert "other aircraft" not in table(add())


def test_it_shows_its_namespace_and_names_the_other_aircraft(add, nodes):
    other = nodes.peer("simulator")
    for name in ("red", "blue"):
        other.create_publisher(ODOMETRY.type, f"{name}/{ODOMETRY.name}", ODOMETRY.qos)
    red, bare = add("red"), add()
    for monitor in (red, bare):
        monitor._refresh()
        for name in ("red/nmpc_controller", "blue/nmpc_controller", "ground_station"):
            tell(monitor, name)
    red_table, bare_table = table(red), table(bare)
    assert "flight of /red" in red_table
    assert "other aircraft in this domain: /blue; watch one with" in red_table
    assert "uav_tracking monitor --namespace /blue" in red_table
    assert "other aircraft in this domain: /blue, /red" in bare_table
    assert "red/nmpc_controller" in red_table
    assert "blue/nmpc_controller" not in red_table
    assert "nmpc_controller" not in bare_table
    assert "ground_station" in red_table
    assert "ground_station" in bare_table
