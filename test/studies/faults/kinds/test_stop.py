from types import SimpleNamespace

import pytest

pytest.importorskip("rclpy")

from uav_tracking_mpc.launch.supervisor import NODES
from uav_tracking_mpc.studies.faults.kinds.stop import Stop


def test_a_frozen_node_goes_on():
    calls = []
    supervisor = SimpleNamespace(
        freeze=lambda name: calls.append(("freeze", name)),
        thaw=lambda name: calls.append(("thaw", name)),
    )
    flight = SimpleNamespace(supervisor=supervisor)
    for fault in Stop.variants():
        fault.begin(flight, 1.0, 0)
        fault.end(flight)
    assert calls == [(action, node) for node in NODES for action in ("freeze", "thaw")]
