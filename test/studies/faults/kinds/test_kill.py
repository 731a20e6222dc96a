import time
from types import SimpleNamespace

import pytest

pytest.importorskip("rclpy")

from uav_tracking_mpc.studies.faults.kinds.kill import RESTART_LIMIT, Kill


@pytest.fixture
def flight():
    calls = []
    supervisor = SimpleNamespace(
        kill=lambda name: calls.append(("kill", name)),
        restart=lambda name: calls.append(("restart", name)),
    )
    return SimpleNamespace(
        supervisor=supervisor, observer=SimpleNamespace(heard={"b": 50.0}), calls=calls
    )


def test_a_killed_node_is_started_and_must_be_heard_again(flight, monkeypatch):
    now = [100.0]
    monkeypatch.setattr(time, "monotonic", lambda: now[0])
    fault = Kill("b")
    fault.begin(flight, 0.5, 0)
    fault.end(flight)
    assert flight.calls == [("kill", "b"), ("restart", "b")]
    assert not fault.settled(flight)
    assert fault.violations(flight) == []
    now[0] += RESTART_LIMIT + 1.0
    assert fault.settled(flight)
    assert [violation.invariant for violation in fault.violations(flight)] == ["restart"]
    now[0] -= 10.0
    flight.observer.heard["b"] = 101.0
    assert fault.settled(flight)
    assert fault.violations(flight) == []
