"""Every stream has a sender among the nodes of a flight, or nothing would go through the relay."""

import pytest

from uav_tracking_mpc.launch.supervisor import NODES
from uav_tracking_mpc.studies.faults.streams import STREAMS


@pytest.mark.parametrize("topic", STREAMS, ids=lambda topic: topic.name)
def test_one_node_of_a_flight_sends_it(topic):
    assert sum(node in topic.sender for node in NODES) == 1
