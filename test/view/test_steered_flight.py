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

"""A flight of three processes is steered as a page does it, and recovers from its faults."""

import json
import os
import subprocess
import threading
import time
from pathlib import Path

import numpy as np
import pytest
import rclpy
from node_harness import vehicle_from_odometry
from processes import DOMAIN, INTERRUPT, command, environment, nodes_of
from rclpy.executors import SingleThreadedExecutor

from uav_tracking_mpc.nodes.messages.conversions import truth_from_odometry
from uav_tracking_mpc.nodes.topics import DIAGNOSTICS, ODOMETRY, TARGET_TRUTH, TRACKING
from uav_tracking_mpc.view.live_source import FAULTS, RosSteering
from uav_tracking_mpc.view.watched_flight import CONTROLLER, SIMULATOR, TARGET

pytestmark = [pytest.mark.nodes, pytest.mark.timeout(1500)]

LIMIT = 400.0  # s of wall time for what may take long on a busy machine
SPEED = 5.0  # simulated over wall time
SETTLED = 10.0  # s of flight within 1 m


class SteeredFlight:
    """``uav_tracking fly`` as a process, and somebody in this one who steers and listens."""

    def __init__(self, folder):
        self.folder = folder
        self.log = (folder / "log").open("w")
        words = ["--config", "small_uav", "--duration", "36000", "--output", folder / "output"]
        words += ["--set", f"mission.speed={SPEED}", "--domain-id", DOMAIN]
        self.process = subprocess.Popen(
            command("cli.main", "fly", *words),
            stdout=self.log,
            stderr=subprocess.STDOUT,
            env=environment(),
        )
        self.context = rclpy.Context()
        self.context.init(args=[], domain_id=int(DOMAIN))
        node = rclpy.create_node("flight_watcher", context=self.context)
        self.steering = RosSteering(node, "")
        self.newest, self.statuses, self.errors = {}, {}, []
        for topic, heard, depth in (
            (ODOMETRY, self._on_state, 1),
            (TARGET_TRUTH, self._on_truth, 1),
            (TRACKING["range_error"], self._on_error, 100),
            (DIAGNOSTICS, self._on_diagnostics, 100),
        ):
            node.create_subscription(topic.type, topic.name, heard, depth)
        self.executor = SingleThreadedExecutor(context=self.context)
        self.executor.add_node(node)
        self.thread = threading.Thread(target=self.executor.spin, daemon=True)
        self.thread.start()

    def _on_state(self, message):
        stamp = message.header.stamp
        self.newest["time"] = stamp.sec + 1e-9 * stamp.nanosec
        self.newest["place"] = vehicle_from_odometry(message)[:3]

    def _on_truth(self, message):
        self.newest["target"] = truth_from_odometry(message)[1]

    def _on_error(self, message):
        self.errors.append((self.newest.get("time", 0.0), message.data))

    def _on_diagnostics(self, message):
        for status in message.status:
            node = status.name.partition(":")[0].strip("/")
            self.statuses[node] = status.message, {v.key: v.value for v in status.values}

    def wait(self, condition, limit=LIMIT):
        deadline = time.monotonic() + limit
        while time.monotonic() < deadline:
            if condition():
                return True
            assert self.process.poll() is None, (self.folder / "log").read_text()
            time.sleep(0.02)
        return False

    def told(self, node=CONTROLLER):
        """What a node says of itself: words and values."""
        return self.statuses.get(node, ("", {}))

    def mode(self):
        return self.told()[1].get("mode", "")

    def circles(self, limit=LIMIT):
        """Whether it comes to fly the orbit within 1 m of range for a while."""
        begin = self.newest.get("time", 0.0)

        def settled():
            errors = list(self.errors)
            since = [time for time, error in errors if abs(error) >= 1.0]
            last = max([begin, *since[-1:]])
            return bool(errors) and errors[-1][0] - last >= SETTLED

        return self.wait(settled, limit)

    def radius(self):
        """Horizontal distance from target to aircraft in [m]."""
        return float(np.linalg.norm((self.newest["place"] - self.newest["target"])[:2]))

    def end(self):
        self.process.send_signal(INTERRUPT)
        code = self.process.wait(2.0 * LIMIT)  # it writes a report
        self.log.close()
        self.executor.shutdown()
        self.thread.join()
        self.context.try_shutdown()
        return code, (self.folder / "log").read_text()


@pytest.fixture(scope="module")
def flight(tmp_path_factory):
    flight = SteeredFlight(tmp_path_factory.mktemp("steered"))
    try:
        assert flight.circles()
        yield flight
    finally:
        if flight.process.poll() is None:
            flight.end()


def test_everything_of_a_simulated_flight_can_be_steered(flight):
    assert flight.steering.nodes == {CONTROLLER, SIMULATOR, TARGET}
    assert set(flight.steering.faults) == set(FAULTS)
    assert flight.steering.parameters(CONTROLLER)["range"] == 300.0
    assert flight.steering.parameters(SIMULATOR)["speed"] == SPEED


def test_it_circles_where_the_target_was_sent(flight):
    height = flight.newest["target"][2]
    assert flight.steering.send_target(60.0, -40.0) == ""
    goal = np.array([60.0, -40.0, height])
    assert flight.wait(lambda: np.array_equal(flight.newest["target"], goal))
    assert flight.circles()


def test_a_range_that_cannot_be_flown_is_refused_in_the_controllers_words(flight):
    words = flight.steering.change(CONTROLLER, range=130.0)
    assert "range" in words and "bank" in words, words
    assert flight.steering.parameters(CONTROLLER)["range"] == 300.0
    assert flight.steering.change(CONTROLLER, range=260.0) == ""
    assert flight.circles()
    before = flight.newest["place"][2] - flight.newest["target"][2]
    assert np.hypot(flight.radius(), before) == pytest.approx(260.0, abs=1.5)
    assert flight.steering.change(CONTROLLER, range=300.0) == ""
    assert flight.circles()


def test_wind_is_flown_in(flight):
    assert flight.steering.change(SIMULATOR, wind=(5.0, 0.0, 0.0)) == ""
    assert flight.wait(lambda: float(flight.told()[1].get("drift east [m/s]", 0.0)) > 4.0)
    assert flight.circles()
    words = flight.steering.change(SIMULATOR, wind=(500.0, 0.0, 0.0))
    assert "'wind' is [500.0, 0.0, 0.0], must be" in words
    assert flight.steering.change(SIMULATOR, wind=(0.0, 0.0, 0.0)) == ""
    assert flight.circles()


def test_simulated_time_is_stopped_and_goes_on(flight):
    assert flight.steering.pause(True) == ""
    assert flight.wait(lambda: "paused" in flight.told(SIMULATOR)[0])

    def stands():
        before = flight.newest["time"]
        time.sleep(1.0)
        return flight.newest["time"] == before

    assert flight.wait(stands)  # what was under way comes still
    paused_at = flight.newest["time"]
    assert flight.steering.pause(False) == ""
    assert flight.wait(lambda: flight.newest["time"] > paused_at + 5.0)
    assert flight.mode() == "optimal plan"


def test_commands_are_taken_away_and_given_back(flight):
    assert flight.steering.engage(False) == ""
    assert flight.wait(lambda: "no plan left" in flight.told(SIMULATOR)[0])
    assert flight.steering.engage(True) == ""
    assert flight.circles()


def test_a_lost_target_is_circled_by_the_law_until_it_is_seen_again(flight):
    assert flight.steering.inject("target lost") == ""
    assert flight.wait(lambda: "kept back" in flight.told(TARGET)[0])
    assert flight.wait(lambda: "loiter" in flight.mode())
    assert flight.wait(lambda: "loiter law" in flight.told()[0])
    assert flight.wait(lambda: flight.mode() == "optimal plan")
    assert flight.circles()


def test_without_a_state_the_plan_is_flown_to_its_end_until_states_come_again(flight):
    assert flight.steering.inject("state lost") == ""
    assert flight.wait(lambda: "kept back" in flight.told(SIMULATOR)[0])
    assert flight.wait(lambda: "vehicle state is lost" in flight.told()[0])
    assert flight.wait(lambda: flight.mode() == "optimal plan")
    assert flight.circles()


def test_a_killed_controller_starts_again_and_flies_on(flight):
    before = nodes_of(flight.process.pid)
    # Faster than a process can start: the plan ends before.
    assert flight.steering.change(SIMULATOR, speed=20.0) == ""
    assert flight.steering.inject("controller killed") == ""
    assert flight.wait(lambda: "no plan left" in flight.told(SIMULATOR)[0])
    assert flight.steering.change(SIMULATOR, speed=SPEED) == ""
    assert flight.wait(lambda: flight.told(SIMULATOR)[0] == "flying on commands")
    assert flight.wait(lambda: flight.mode() == "optimal plan")
    after = nodes_of(flight.process.pid)
    assert after[CONTROLLER] != before.pop(CONTROLLER)
    assert {name: after[name] for name in before} == before
    assert flight.circles()


def test_what_was_flown_is_reported(flight):
    code, words = flight.end()
    assert code == 130, words
    assert "Traceback" not in words
    metrics = json.loads((Path(flight.folder) / "output" / "metrics.json").read_text())
    assert metrics["commands"]["sent"] > 500
    assert os.path.getsize(flight.folder / "output" / "report.html") > 0
