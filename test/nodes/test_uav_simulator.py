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

"""The simulator node flies any plant, and outlives one that fails."""

import functools

import numpy as np
import pytest
from filled_messages import filled_orbit
from processes import wait_for
from rclpy.parameter import Parameter
from std_srvs.srv import Trigger

from uav_tracking_mpc.dynamics.orbit import FlownOrbit
from uav_tracking_mpc.nodes.ros.diagnostics import ERROR
from uav_tracking_mpc.nodes.ros.endpoints import OUTAGE
from uav_tracking_mpc.nodes.topics import ODOMETRY
from uav_tracking_mpc.nodes.uav_simulator import UavSimulator
from uav_tracking_mpc.simulation.plants.vehicle import VehiclePlant

pytestmark = pytest.mark.nodes

FAILING = """
from uav_tracking_mpc.simulation.plants.vehicle import VehiclePlant


class Failing(VehiclePlant):
    name = "failing"

    def advance(self, duration):
        super().advance(duration)
        if self.time > 0.2 and not {measuring}:
            raise RuntimeError("the wing came off")

    def measured(self):
        if self.time > 0.24 and {measuring}:
            raise RuntimeError("the wing came off")
        return super().measured()
"""


@pytest.fixture
def simulator(nodes):
    """Makes the node with parameters, with when it has published which x."""

    def make(**parameters):
        published = []
        node = nodes.add(UavSimulator, initial_speed=8.0, **parameters)
        node._state_publisher.publisher.publish = lambda state: published.append(
            (node._now, state.pose.pose.position.x)
        )
        node.published = published
        return node

    return make


@pytest.mark.parametrize("measuring", [False, True])
def test_a_plant_of_ones_own_is_flown_until_it_fails(simulator, tmp_path, measuring):
    file = tmp_path / "failing.py"
    file.write_text(FAILING.format(measuring=measuring))
    node = simulator(plant=f"{file}:Failing", publish_clock=True)
    for _ in range(10):
        node._step()
    assert len(node.published) == 4  # at 0.05, 0.1, 0.15 and 0.2 s
    assert node._diagnostics.status.level == ERROR
    assert "the wing came off" in node._diagnostics.status.message
    assert node._now == 500_000_000  # time goes on
    one_step = 0.05 * 8.0  # m: it had flown on when it could not be measured
    assert node._values()["x [m]"] == pytest.approx(node.published[-1][1], abs=one_step)


@pytest.mark.parametrize("failing", ["wind", "see_orbit", "check"])
def test_nothing_of_a_plant_ends_the_node(simulator, monkeypatch, failing):
    def fail(*arguments):
        raise RuntimeError("the wing came off")

    node = simulator(publish_clock=True)
    monkeypatch.setattr(VehiclePlant, failing, property(fail) if failing == "wind" else fail)
    node._step()
    node._on_orbit(filled_orbit(0, FlownOrbit(np.zeros(3), np.zeros(3), 100.0, 9.0)))
    answer = node.set_parameters_atomically([Parameter("wind", value=[1.0, 0.0, 0.0])])
    assert answer.successful == (failing != "check")
    node._diagnostics.publish()
    assert not node._failure


def test_an_autopilot_that_holds_altitude_and_airspeed_is_told_the_orbit(simulator):
    node = simulator(plant="held", publish_clock=True)
    orbit = FlownOrbit(np.array([0.0, 0.0, 40.0]), np.zeros(3), 100.0, 9.0)
    message = filled_orbit(50_000_000, orbit)
    node._on_orbit(message)
    assert (node._plant.altitude, node._plant.airspeed) == (40.0, 9.0)
    message.position[2] = float("nan")
    node._on_orbit(message)  # refused
    assert node._plant.altitude == 40.0


def test_time_begins_for_who_needs_the_state_and_not_for_who_looks(simulator, nodes):
    """A page or a monitor may be there first; the record would lack the begin."""
    node = simulator(publish_clock=True, wait_for_subscribers=1)

    def add(name):
        nodes.peer(name).create_subscription(ODOMETRY.type, ODOMETRY.name, print, 1)
        known = functools.partial(node.get_subscriptions_info_by_topic, ODOMETRY.name)
        assert wait_for(lambda: name in [one.node_name for one in known()])

    for name in ("flight_watcher", "monitor"):
        add(name)
        node._step()
        assert node._now == 0
    add("flight_recorder")
    node._step()
    assert node._now > 0


def test_a_lost_state_comes_again_by_itself(simulator):
    node = simulator(publish_clock=True)
    node._step()
    (lose,) = [each for each in node.services if each.srv_name.endswith("lose_state")]
    assert lose.callback(Trigger.Request(), Trigger.Response()).success
    begin = node._now
    node._step()
    assert (
        node._diagnostics.status.message
        == "the state is kept back for 15 s by the service lose_state"
    )
    for _ in range(round(OUTAGE * node.parameters.state_rate)):
        node._step()
    (last, _), (again, _), *_ = node.published
    assert last == begin
    assert (again - last) * 1e-9 == pytest.approx(OUTAGE)
    assert node._diagnostics.status.message == "waiting for the first command"
