"""Messages right and wrong, thousands of them: nothing raises, nothing leaves its limits."""

import numpy as np
import pytest
import rclpy
from rclpy.signals import SignalHandlerOptions

from uav_tracking_mpc.nodes.command_wire import CommandWire
from uav_tracking_mpc.nodes.topics import AIR_VELOCITY, COMMAND, ODOMETRY, TARGET
from uav_tracking_mpc.nodes.uav_simulator import UavSimulator
from uav_tracking_mpc.settings.configuration import load_configuration
from uav_tracking_mpc.studies.faults.message_fuzz import ControllerFuzz, VehicleFuzz, fuzz
from uav_tracking_mpc.studies.faults.node_harness import Findings, quiet

pytestmark = pytest.mark.nodes

TOPICS = {topic.name for topic in (ODOMETRY, AIR_VELOCITY, TARGET, COMMAND)}


@pytest.mark.timeout(300)
def test_nothing_breaks():
    """The short form; the full one is `uav_tracking torture --messages 100000`."""
    told = []
    summary = fuzz(load_configuration("small_uav"), 800, 1, lambda *done: told.append(done))
    assert summary["exceptions"] == summary["violations"] == 0, summary["examples"]
    assert set(summary["messages"]) == TOPICS
    assert min(summary["messages"].values()) >= 800
    assert all(0 < summary["refused"][topic] < summary["messages"][topic] for topic in TOPICS)
    assert told[-1] == ("vehicle", summary["messages"][COMMAND.name])


@pytest.fixture
def ros():
    rclpy.init(args=[], signal_handler_options=SignalHandlerOptions.NO)
    quiet()
    yield
    rclpy.try_shutdown()


def found(kind, count):
    findings = Findings()
    kind(load_configuration("paper"), 0, findings).run(count, lambda done: None)
    return findings


@pytest.mark.timeout(120)
def test_an_exception_in_a_callback_is_found(ros, monkeypatch):
    def careless(message):
        return np.linalg.inv(np.diag([message.point.x, 1.0, 1.0])).diagonal()

    monkeypatch.setattr("uav_tracking_mpc.nodes.conversions.position_from_point", careless)
    findings = found(ControllerFuzz, 500)
    assert findings.exceptions > 10
    assert "LinAlgError" in findings.examples[0]


@pytest.mark.timeout(120)
def test_a_command_outside_the_limits_is_found(ros, monkeypatch):
    write = CommandWire.write
    monkeypatch.setattr(
        CommandWire, "write", lambda wire, stamp, plan, step: write(wire, stamp, 1.5 * plan, step)
    )
    assert found(ControllerFuzz, 500).violations["command limits"] > 10


@pytest.mark.timeout(120)
def test_a_refused_command_that_is_flown_all_the_same_is_found(ros, monkeypatch):
    on_command = UavSimulator._on_command

    def careless(self, message):
        if message.points:
            self._plant._end += 1.0
        on_command(self, message)

    monkeypatch.setattr(UavSimulator, "_on_command", careless)
    assert found(VehicleFuzz, 500).violations["half applied"] > 10


@pytest.mark.timeout(120)
def test_the_same_seed_finds_the_same(ros):
    first, second = found(VehicleFuzz, 500), found(VehicleFuzz, 500)
    assert (first.messages, first.refused) == (second.messages, second.refused)
