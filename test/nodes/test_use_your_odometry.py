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

"""The example of a strange odometry: best effort, 30 Hz, 80 ms late, frames of other names."""

from dataclasses import asdict

import numpy as np
import pytest
from filled_messages import filled_clock, filled_measurement
from geometry_msgs.msg import Vector3Stamped
from nav_msgs.msg import Odometry
from node_flight import ON_ORBIT, PATIENT
from node_harness import Nodes, overrides
from rclpy.qos import qos_profile_sensor_data
from sources import ROOT, loaded

from uav_tracking_mpc.nodes.nmpc_controller import NmpcController
from uav_tracking_mpc.nodes.target_publisher import TargetPublisher
from uav_tracking_mpc.nodes.topics import CLOCK
from uav_tracking_mpc.settings.configuration import load_configuration
from uav_tracking_mpc.simulation.plants import plant_of

pytestmark = pytest.mark.nodes
EXAMPLE = ROOT / "examples" / "use_your_odometry.py"
MOST_LINES = 60  # of Python, as its page says
TICKS_PER_STATE, TICK = 5, 1 / 150  # s; 30 states a second
LATE = 12  # ticks: 80 ms
DURATION = 15.0  # s


class StrangeAircraft:
    """An aircraft in simulated time: a late odometry out, rates in.

    Args:
        peer: Node by which it talks.
        plant: What flies.
    """

    def __init__(self, peer, plant):
        self.plant, self._ticks, self._under_way = plant, 0, []
        self._clock = peer.create_publisher(CLOCK.type, CLOCK.name, CLOCK.qos)
        self._odometry = peer.create_publisher(Odometry, "ekf/odometry", qos_profile_sensor_data)
        peer.create_subscription(Vector3Stamped, "autopilot/rates", self._on_rates, 1)

    def _on_rates(self, rates):
        inputs = [rates.vector.x, rates.vector.y, rates.vector.z]
        self.plant.accept([inputs], [self.plant.time])

    def tick(self):
        """Fly on; returns the time of the state that it sends in [s], if it sends one."""
        self._ticks += 1
        self.plant.advance(TICK)
        now = round(self._ticks * TICK * 1e9)
        self._clock.publish(filled_clock(now))
        if self._ticks % TICKS_PER_STATE == 0:
            message = filled_measurement(now, self.plant.measured())
            message.header.frame_id, message.child_frame_id = "odom", "base_footprint"
            self._under_way.append((self._ticks + LATE, self.plant.time, message))
        if not self._under_way or self._under_way[0][0] > self._ticks:
            return None
        _, time, message = self._under_way.pop(0)
        self._odometry.publish(message)
        return time

    def error(self, orbit):
        """Of range and altitude about the origin in [m]."""
        position = self.plant.truth.position
        return np.linalg.norm(position) - orbit.range, position[2] - orbit.altitude


def test_it_holds_the_orbit_in_wind(nodes: Nodes):
    configuration = load_configuration("small_uav", [*ON_ORBIT, PATIENT], "wind")
    aircraft = StrangeAircraft(nodes.peer("aircraft"), plant_of(configuration))
    nodes.add(TargetPublisher, use_sim_time=True)
    node = nodes.add(NmpcController, use_sim_time=True, **asdict(configuration.controller))
    adapter = loaded(EXAMPLE).OdometryAdapter(
        context=nodes.context, parameter_overrides=overrides({"use_sim_time": True})
    )
    nodes.join(adapter)
    errors, answered = [], 0
    while aircraft.plant.time < DURATION:
        sent = aircraft.tick()
        if sent is not None:
            before = node.controller.state_time
            nodes.spin(lambda before=before: node.controller.state_time != before, limit=0.5)
            answered += node.controller.state_time != before
        else:
            nodes.executor.spin_once(timeout_sec=0.0)
        errors.append(aircraft.error(node.controller.orbit))
    assert answered > 0.95 * 30.0 * (DURATION - LATE * TICK)
    assert np.abs(errors[-900:]).max() < 1.0
    # The wall time of the solves comes on top.
    assert node.controller.navigator.latency > 0.95 * LATE * TICK


def test_it_is_short():
    code = EXAMPLE.read_text().partition('"""')[2]
    assert len(code.splitlines()) <= MOST_LINES
