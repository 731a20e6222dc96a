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

import importlib.util
import json
import os
import subprocess
import time
from pathlib import Path

import numpy as np
import pytest
from processes import (
    DOMAIN,
    INTERRUPT,
    KILL,
    alive,
    children_of,
    command,
    environment,
    nodes_of,
    wait_for,
)

from uav_tracking_mpc.control.fallback import FallbackMode
from uav_tracking_mpc.nodes import watching
from uav_tracking_mpc.view.live_source import FAULTS, LiveSource
from uav_tracking_mpc.view.watched_flight import CONTROLLER, SILENT, SIMULATOR, TARGET, NodeStatus

pytestmark = pytest.mark.nodes

SPEED = 5.0  # simulated over wall time, where the machine keeps up
PATIENCE = 30.0  # s of wall time, after which the flight is slowed down
LIMIT = 600.0  # s of wall time; for what is broken
ANSWER = 60.0  # s of wall time, that a node on a busy machine may take to answer
SETTLED = 5.0  # s of flight within 1 m
NEAR = (
    *("--set", "uav_simulator.initial_position=[275.0, 0.0, 120.0]"),
    *("--set", "uav_simulator.initial_heading=1.5707963267948966"),
)


class SteeredFlight:
    """``uav_tracking fly`` as a process, watched and steered in this one as a page does it.

    Its own page dies before the flight begins. After a first wait that was in vain no other is
    begun, in no other flight either.
    """

    broken = False
    page = None  # its process

    def __init__(self, folder):
        self.folder, self.source = folder, LiveSource(int(DOMAIN))
        words = ["--config", "small_uav", "--duration", "36000", "--output", folder / "output"]
        words += ["--set", "mission.speed=1.0", *NEAR, "--domain-id", DOMAIN]
        viewed = importlib.util.find_spec("viser") is not None
        words += ["--view", "--no-browser", "--port", "0"] if viewed else []
        self.speed = 1.0
        self.log = (folder / "log").open("w")
        self.process = subprocess.Popen(
            command("cli.main", "fly", *words),
            stdout=self.log,
            stderr=subprocess.STDOUT,
            env=environment(),
        )
        if viewed:
            told = folder / "log"
            assert wait_for(lambda: "page: http" in told.read_text() or self.process.poll())
            children = children_of(self.process.pid)
            (self.page,) = (child for child, words in children if " view --domain-id " in words)
            os.kill(self.page, KILL)

    @property
    def watched(self):
        (aircraft,) = self.source.flights()
        return aircraft

    @property
    def steering(self):
        return self.watched.steering

    @property
    def sight(self):
        return self.watched.sight

    def fly_at(self, speed):
        self.speed = speed
        return self.steering.change(SIMULATOR, speed=speed)

    def wait(self, condition):
        """Whether it comes to hold; on a busy machine the flight is slowed down until it can."""
        assert not SteeredFlight.broken
        slowed = time.monotonic()

        def goes_on():
            nonlocal slowed
            assert self.process.poll() is None, (self.folder / "log").read_text()
            if self.speed > 1.0 and time.monotonic() - slowed > PATIENCE:
                slowed = time.monotonic()
                assert self.fly_at(max(0.5 * self.speed, 1.0)) == ""
            return condition()

        SteeredFlight.broken = not wait_for(goes_on, LIMIT)
        return not SteeredFlight.broken

    def told(self, node=CONTROLLER):
        """What a node says of itself."""
        unknown = NodeStatus(node, SILENT, "")
        return next((each for each in self.sight.statuses if each.node == node), unknown)

    def flies(self, mode):
        return self.wait(lambda: self.sight.mode is mode)

    def says(self, words, node=CONTROLLER):
        return self.wait(lambda: words in self.told(node).words)

    def circles(self):
        """Whether it comes to fly the orbit within 1 m of range for a while."""
        begin = self.sight.time

        def settled():
            now, past = self.sight.time, self.watched.past(SETTLED)
            errors = [abs(sight.errors.get("range_error", np.inf)) for sight in past]
            return now - begin > SETTLED and max(errors) < 1.0

        return self.wait(settled)

    def end(self):
        self.source.close()
        self.process.send_signal(INTERRUPT)
        code = self.process.wait(LIMIT)  # it writes a report
        self.log.close()
        return code, (self.folder / "log").read_text()


@pytest.fixture(scope="module")
def flight(tmp_path_factory):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(watching, "LIMIT", ANSWER)
        flight = SteeredFlight(tmp_path_factory.mktemp("steered"))
        try:
            assert flight.wait(lambda: not flight.source.words)
            assert flight.wait(lambda: flight.fly_at(SPEED) == "")
            assert flight.circles()
            yield flight
        finally:
            if flight.process.poll() is None:
                flight.end()


def test_everything_of_a_simulated_flight_can_be_steered(flight):
    assert flight.steering.nodes == {CONTROLLER, SIMULATOR, TARGET}
    assert set(flight.steering.faults) == set(FAULTS)
    assert flight.steering.parameters(CONTROLLER)["range"] == 300.0
    assert flight.steering.parameters(SIMULATOR)["speed"] == flight.speed


def test_a_page_that_dies_ends_no_flight(flight):
    """All tests here are of a flight without it."""
    if flight.page is None:
        pytest.skip("viser is not installed")
    assert not alive(flight.page)
    assert flight.process.poll() is None


@pytest.mark.long
def test_it_circles_where_the_target_was_sent(flight):
    goal = np.array([60.0, -40.0, flight.sight.target.truth[2]])
    assert flight.steering.send_target(60.0, -40.0) == ""
    assert flight.wait(lambda: np.array_equal(flight.sight.target.truth, goal))
    assert flight.circles()


def test_a_range_that_cannot_be_flown_is_refused_in_the_controllers_words(flight):
    words = flight.steering.change(CONTROLLER, range=130.0)
    assert "range" in words and "bank" in words, words
    assert flight.steering.parameters(CONTROLLER)["range"] == 300.0
    assert flight.steering.change(CONTROLLER, range=260.0) == ""
    assert flight.circles()

    def away():  # on a busy machine commands are late, and one sight alone may be off
        return np.linalg.norm(flight.sight.position - flight.sight.target.truth)

    assert flight.wait(lambda: away() == pytest.approx(260.0, abs=1.5))
    assert flight.steering.change(CONTROLLER, range=300.0) == ""


@pytest.mark.long
def test_wind_is_flown_in(flight):
    assert flight.steering.change(SIMULATOR, wind=(5.0, 0.0, 0.0)) == ""
    assert flight.wait(lambda: float(flight.told().values.get("drift east [m/s]", 0.0)) > 4.0)
    assert flight.circles()
    words = flight.steering.change(SIMULATOR, wind=(500.0, 0.0, 0.0))
    assert "'wind' is [500.0, 0.0, 0.0], must be" in words
    assert flight.steering.change(SIMULATOR, wind=(0.0, 0.0, 0.0)) == ""


def test_simulated_time_is_stopped_and_goes_on(flight):
    assert flight.steering.pause(True) == ""
    assert flight.says("paused", SIMULATOR)

    def stands():
        before = flight.sight.time
        time.sleep(1.0)
        return flight.sight.time == before

    assert flight.wait(stands)  # what was under way comes still
    paused_at = flight.sight.time
    assert flight.steering.pause(False) == ""
    assert flight.wait(lambda: flight.sight.time > paused_at + 5.0)
    assert flight.flies(FallbackMode.OPTIMAL)


@pytest.mark.long
def test_commands_are_taken_away_and_given_back(flight):
    assert flight.steering.engage(False) == ""
    assert flight.says("no plan left", SIMULATOR)
    assert flight.steering.engage(True) == ""
    assert flight.circles()


@pytest.mark.long
def test_a_lost_target_is_circled_by_the_law_until_it_is_seen_again(flight):
    assert flight.steering.inject("target lost") == ""
    assert flight.says("kept back", TARGET)
    assert flight.flies(FallbackMode.LOITER)
    assert flight.says("loiter law")
    assert flight.flies(FallbackMode.OPTIMAL)
    assert flight.circles()


@pytest.mark.long
def test_without_a_state_the_plan_is_flown_to_its_end_until_states_come_again(flight):
    assert flight.steering.inject("state lost") == ""
    assert flight.says("kept back", SIMULATOR)
    assert flight.says("vehicle state is lost")
    assert flight.flies(FallbackMode.OPTIMAL)
    assert flight.circles()


def test_a_killed_controller_starts_again_and_flies_on(flight):
    before = nodes_of(flight.process.pid)
    killed = before.pop(CONTROLLER)
    usual = flight.speed
    # Faster than a process can start: the plan ends before.
    assert flight.fly_at(20.0) == ""
    assert flight.steering.inject("controller killed") == ""
    # A controller that is late at this speed leaves no plan, too, before it is killed.
    assert flight.wait(lambda: nodes_of(flight.process.pid).get(CONTROLLER) != killed)
    assert flight.says("no plan left", SIMULATOR)
    assert flight.fly_at(usual) == ""
    assert flight.says("flying on commands", SIMULATOR)
    assert flight.flies(FallbackMode.OPTIMAL)
    assert nodes_of(flight.process.pid)[CONTROLLER] != killed
    after = nodes_of(flight.process.pid)
    assert {name: after[name] for name in before} == before
    assert flight.circles()


def test_what_was_flown_is_reported(flight):
    code, words = flight.end()
    assert code == 130, words
    assert "Traceback" not in words
    assert "of 36000 s were flown" in words
    metrics = json.loads((Path(flight.folder) / "output" / "metrics.json").read_text())
    assert metrics["commands"]["sent"] > 100
    assert metrics["duration_s"] < 36000.0
    assert os.path.getsize(flight.folder / "output" / "report.html") > 0
