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

"""A flight is steered by hand in a real browser."""

import re
import signal
import subprocess
import threading

import numpy as np
import pytest
from processes import command, environment
from seen_page import SeenPage, served

from uav_tracking_mpc.control.fallback import FallbackMode
from uav_tracking_mpc.settings.configuration import load_configuration
from uav_tracking_mpc.view.watched_flight import CONTROLLER, SIMULATOR

pytestmark = [pytest.mark.browser, pytest.mark.timeout(900)]

SETTLE = 60.0  # s of simulated time after which the new place is circled
LAPS = 60.0  # s of simulated time for which it is
FAST, SLOW = 100.0, 0.1  # simulated over wall time
# viser says so of itself wherever the mouse takes hold of something in the scene.
VISER = "Unable to preventDefault inside passive event listener invocation."


@pytest.fixture(scope="module")
def source():
    """``small_uav`` as fast as the wall's time, by a controller that may take its time."""
    from uav_tracking_mpc.view.simulated_source import SimulatedSource

    overrides = ["mission.speed=1.0", "nmpc_controller.solve_time_max=5.0"]
    source = SimulatedSource(load_configuration("small_uav", overrides))
    yield source
    source.close()


@pytest.fixture(scope="module")
def opened(context, source):
    with served(source) as page:
        yield SeenPage(context.new_page(), page.address)


@pytest.fixture
def seen(opened, source):
    """The page that tests share, of a flight by an optimal plan."""
    opened.errors.clear()
    (flight,) = source.flights()
    flight.steering.change(SIMULATOR, speed=1.0)
    flight.steering.pause(False)
    opened.wait_for_text("optimal plan")
    return opened


def test_the_target_is_dragged_and_the_aircraft_circles_its_new_place(seen, source):
    (flight,) = source.flights()
    head, west_north = np.array([0.0, 0.0, 10.0]), np.array([-100.0, 60.0, 0.0])
    seen.drag(seen.pixel_of(head), seen.pixel_of(head + west_north))
    target = flight.loop.target
    seen.eventually(lambda: any(target.parameters.position), "the target is sent away")
    begin = flight.sight.time
    flight.steering.change(SIMULATOR, speed=FAST)
    seen.eventually(lambda: flight.sight.time > begin + SETTLE + LAPS, "the flight goes on")
    place = flight.sight.target.truth
    np.testing.assert_allclose(place, west_north, atol=20.0)
    circling = [past for past in flight.past(SETTLE + LAPS) if past.time > begin + SETTLE]
    assert circling[-1].time - circling[0].time > 0.9 * LAPS
    for past in circling:
        np.testing.assert_allclose(past.target.truth, place)
        range_ = np.linalg.norm(past.position - place)
        assert abs(range_ - flight.tracking.range) < 1.0
    assert set(seen.errors) <= {VISER}


def test_a_range_that_cannot_be_flown_is_refused_in_the_controllers_words(seen, source):
    (flight,) = source.flights()
    flown = flight.tracking.range
    refusal = flight.steering.change(CONTROLLER, range=40.0)
    assert refusal
    seen.wait_for_text("range [m]")
    assert seen.entered("range [m]") == flown
    seen.enter("range [m]", 40.0, lambda: seen.shows(refusal))
    seen.eventually(lambda: seen.entered("range [m]") == flown, "the slider goes back")
    assert flight.tracking.range == flown
    seen.enter("range [m]", 350.0, lambda: flight.tracking.range == 350.0)
    assert seen.errors == []


def test_a_killed_controller_shows_the_fallback_and_then_the_recovery(seen, source):
    """Time goes slowly, then stands: the fallback lasts until the page has shown it."""
    (flight,) = source.flights()
    flight.steering.change(SIMULATOR, speed=SLOW)
    seen.press("controller killed")
    seen.eventually(lambda: flight.sight.mode is FallbackMode.SILENCE, "nothing is commanded")
    flight.steering.pause(True)
    seen.wait_for_text("now flying")
    seen.wait_for_text("the controller was killed")
    flight.steering.change(SIMULATOR, speed=1.0)
    flight.steering.pause(False)
    seen.wait_for_text("recovered")
    seen.wait_for_text("optimal plan")
    assert seen.errors == []


@pytest.mark.nodes
@pytest.mark.long
def test_a_killed_node_shows_the_fallback_and_then_the_recovery(look, tmp_path):
    """The same with nodes as processes: the page hears of it over ROS topics.

    Nothing holds up a flight of nodes while its page is drawn, hence the words that stay: that it
    has recovered is told of what was seen to fall back, and the list of fallbacks says from what.
    """
    pytest.importorskip("rclpy", reason="needs ROS 2")
    from uav_tracking_mpc.nodes.topics import COMMAND

    words = ["--config", "small_uav", "--view", "--no-browser", "--port", "0"]
    words += ["--duration", "36000", "--speed", "1", "--output", tmp_path]
    process = subprocess.Popen(
        command("cli.main", "fly", *words), stderr=subprocess.PIPE, text=True, env=environment()
    )
    try:
        addresses = (re.search(r"page: (\S+)", line) for line in process.stderr)
        seen = look(next(filter(None, addresses))[1])
        threading.Thread(target=process.stderr.read, daemon=True).start()  # lest it fills the pipe
        seen.wait_for_text("optimal plan")
        seen.press("controller killed")
        seen.wait_for_text("recovered")
        seen.page.get_by_text("History:").first.click()  # it is folded
        seen.wait_for_text(f"nothing comes on {COMMAND.name}")
        assert seen.errors == []
    finally:
        process.send_signal(signal.SIGTERM)
        process.wait()
