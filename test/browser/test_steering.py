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

"""What a stranger sees at first, finds without scrolling, steers by hand and takes along."""

import io
import re
import signal
import subprocess
import threading
from urllib.parse import quote

import numpy as np
import pytest
from PIL import Image
from processes import command, environment
from seen_page import SeenPage, served

from uav_tracking_mpc.control.fallback import FallbackMode
from uav_tracking_mpc.settings.configuration import load_configuration
from uav_tracking_mpc.view.panel.mission_file import mission_of
from uav_tracking_mpc.view.watched_flight import CONTROLLER, SIMULATOR

pytestmark = pytest.mark.browser
SCREEN = {"width": 1280, "height": 800}
SLOW = 0.1  # simulated over wall time
# viser says so of itself wherever the mouse takes hold of something in the scene.
VISER = "Unable to preventDefault inside passive event listener invocation."


@pytest.fixture(scope="module")
def flight():
    """``small_uav`` by a law that is quick to fly."""
    from uav_tracking_mpc.view.simulated_source import SimulatedSource

    overrides = ["mission.speed=1.0", "nmpc_controller.law=l1"]
    source = SimulatedSource(load_configuration("small_uav", overrides, "crosswind"))
    (flight,) = source.flights()
    flight.source = source
    return flight


@pytest.fixture(scope="module")
def seen(chromium, flight):
    """The page that tests share."""
    context = chromium.new_context(viewport=SCREEN, accept_downloads=True)
    with served(flight.source) as page:
        # In as many pixels as it has: a page of few is a small one, on which the legend is folded.
        shown = SeenPage(context.new_page(), page.address, resolution=1.0)
        shown.scene = page._server.scene
        yield shown
    context.close()


# Where the first text stands that is some words, or has them in it, in one question: a page that is
# drawn slowly answers each of them late.
BOX = """([words, exact]) => {
  const walk = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  for (let node; (node = walk.nextNode()); ) {
    const text = node.textContent.trim();
    const found = node.parentElement.getBoundingClientRect();
    const same = exact ? text === words : text.includes(words);
    if (same && found.width * found.height) return found.toJSON();
  }
  return null;
}"""


def box(seen, words, exact=True):
    """Where words stand on the page."""
    found = []

    def stands():  # what is written anew in that moment stands nowhere
        found.append(seen.page.evaluate(BOX, [words, exact]))
        return found[-1] is not None

    seen.eventually(stands, f"{words} is seen")
    return found[-1]


def test_orbit_and_words_of_the_wind_stand_in_what_panel_and_legend_leave(seen, flight):
    """From wherever it blows."""
    panel, legend = box(seen, "Orbit"), seen.page.locator("[data-flight-legend]").bounding_box()
    left, right = legend["x"] + legend["width"], panel["x"]
    # The scene moves with the target: where the first view looks, its middle stays.
    wanted = flight.sight.wanted
    turn = np.linspace(0.0, 2.0 * np.pi, 24)
    circle = abs(wanted.radius) * np.stack([np.cos(turn), np.sin(turn), 0.0 * turn], axis=1)
    height, middle = [0.0, 0.0, wanted.centre[2]], 0.5 * (left + right)

    def framed():  # as soon as the camera has come to its place
        column, row = seen.pixel_of((0.0, 0.0, 60.0))
        across = np.abs(seen.pixel_of(circle + height)[:, 0] - middle)
        upright = 0.3 * SCREEN["height"] < row < 0.7 * SCREEN["height"]
        return abs(column - middle) < 30.0 and upright and np.all(across < middle - left)

    seen.eventually(framed, "the orbit is framed")
    place, label = (seen.scene.get_handle_by_name(f"/world/small_uav/wind{part}")
                    for part in ("", "/label"))  # fmt: skip
    for wind, sector in (((0.0, -8.0), "N"), ((6.0, -6.0), "NW"), ((8.0, 0.0), "W")):
        flight.steering.change(SIMULATOR, wind=(*wind, 0.0))
        seen.eventually(lambda said=f"from {sector}": label.text.endswith(said), "the words say it")
        column, row = seen.pixel_of(np.add(label.position, [0.0, 0.0, place.position[2]]))
        assert left < column - 70.0 < column + 70.0 < right
        assert row < seen.page.locator("#flight-strip").bounding_box()["y"]


def test_a_legend_says_what_is_seen_and_makes_room_for_the_head_up_display(seen):
    plan = "the plan: where it flies next"
    for words in (plan, "the orbit that is asked for", "Drag the target"):
        assert box(seen, words)["x"] < 300.0
    assert seen.errors == []
    legend, display = seen.page.get_by_text(plan), seen.page.get_by_role("button", name="HUD")
    display.press("Enter")
    legend.wait_for(state="hidden")
    assert seen.page.get_by_text("Orbit", exact=True).first.is_visible()
    display.press("Enter")
    legend.wait_for(state="visible")


def test_questions_stand_in_their_order_down_to_the_wind_without_scrolling(seen):
    order = ("Range", "Orbit", "Target", "Wind", "Faults", "classical laws")
    heights = [box(seen, words)["y"] for words in order]
    well = box(seen, "nearest limit", False)["y"]
    assert heights == sorted(heights)
    assert well < heights[0]
    strip = seen.page.locator("#flight-strip").bounding_box()
    assert heights[order.index("Wind")] < strip["y"]
    for folded in ("History:", "Solver:", "Diagnostics:"):
        assert box(seen, folded, False)["y"] > heights[-1]


def test_the_target_is_sent_to_where_it_is_dragged(seen, flight):
    head, west_north = np.array([0.0, 0.0, 10.0]), np.array([-100.0, 60.0, 0.0])
    target = flight.loop.target
    flight.steering.pause(True)  # the scene goes with the target
    before = flight.sight.target.truth
    seen.drag(seen.pixel_of(head), seen.pixel_of(head + west_north))
    seen.eventually(lambda: target.parameters.motion == "stationary", "the target is sent away")
    flight.steering.pause(False)
    np.testing.assert_allclose(target.parameters.position, before + west_north, atol=25.0)
    assert set(seen.errors) <= {VISER}
    seen.errors.clear()


def test_a_refusal_stands_where_the_value_was_typed_and_the_slider_goes_back(seen, flight):
    """In the controller's words."""
    flown = flight.tracking.range
    refusal = flight.steering.change(CONTROLLER, range=40.0)
    assert refusal
    seen.enter("range [m]", 40.0, lambda: seen.shows(refusal))
    seen.eventually(lambda: seen.entered("range [m]") == flown == flight.tracking.range, "it is")
    said = box(seen, refusal, False)["y"]
    assert box(seen, "range [m]")["y"] < said < box(seen, "altitude [m]")["y"]
    seen.enter("range [m]", 350.0, lambda: flight.tracking.range == 350.0)
    assert seen.errors == []


def test_a_killed_controller_shows_the_fallback_and_then_the_recovery(seen, flight):
    """Time goes slowly, then stands: the fallback lasts until the page has shown it."""
    flight.steering.change(SIMULATOR, speed=SLOW)
    seen.press("controller killed")
    seen.eventually(lambda: flight.sight.mode is FallbackMode.SILENCE, "nothing is commanded")
    flight.steering.pause(True)
    seen.wait_for_text("now flying")
    seen.wait_for_text("the controller was killed")
    flight.steering.change(SIMULATOR, speed=1.0)
    flight.steering.pause(False)
    seen.wait_for_text("recovered")
    assert seen.errors == []


def test_the_classical_laws_fly_beside_when_asked_for(seen, flight):
    seen.page.get_by_role("checkbox").first.wait_for(state="attached")
    seen.row("classical laws").locator("input").check(force=True)
    seen.wait_for_text("RMS, last minute")
    assert {rival.law for rival in flight.sight.rivals} >= {"l1", "npfg", "vector_field"}
    seen.row("classical laws").locator("input").uncheck(force=True)
    seen.eventually(lambda: not flight.sight.rivals, "they end")


def test_a_flight_that_goes_on_is_seen_as_it_was(seen, flight):
    canvas = seen.page.locator("#flight-strip canvas")
    seen.eventually(lambda: int(canvas.get_attribute("data-rows") or 0) > 15, "the strip has rows")
    canvas.focus()
    canvas.press("PageDown")
    seen.wait_for_element("#flight-words", "The picture is of the past")
    shown = seen.page.locator("#flight-time").text_content()
    begin = flight.sight.time
    seen.eventually(lambda: flight.sight.time > begin, "the flight goes on")
    assert seen.page.locator("#flight-time").text_content() == shown
    seen.page.get_by_role("button", name="live", exact=True).press("Enter")
    seen.page.locator("body:not(.flight-past)").wait_for()


def saved(seen, button, suffix):
    """The file that a button saves."""
    with seen.page.expect_download() as saving:
        seen.press(button)
    path = saving.value.path().with_suffix(suffix)
    saving.value.save_as(path)
    return path


def test_a_picture_and_the_mission_are_saved(seen, flight):
    picture = saved(seen, "Save a picture", ".png").read_bytes()
    assert np.asarray(Image.open(io.BytesIO(picture)).convert("RGB")).std() > 1.0  # of something
    flight.steering.change(SIMULATOR, wind=(3.0, -4.0, 0.0))
    seen.page.get_by_text("Mission file", exact=True).click()
    mission = load_configuration("small_uav", scenario=str(saved(seen, "Save mission", ".yaml")))
    assert mission.simulator.wind == (3.0, -4.0, 0.0)
    assert mission.controller.range == flight.tracking.range


def test_a_mission_in_the_address_is_flown_when_that_is_asked_for(seen, flight):
    flight.steering.change(SIMULATOR, wind=(3.0, -4.0, 0.0))
    mission = quote(mission_of(flight.steering, flight.name))
    flight.steering.change(SIMULATOR, wind=(0.0, 0.0, 0.0))
    address = seen.page.url.partition("?")[0]
    seen.page.goto("about:blank")
    seen.open(f"{address}#mission={mission}", ready=False)
    seen.wait_for_text("This address holds a mission")
    assert flight.steering.parameters(SIMULATOR)["wind"] == (0.0, 0.0, 0.0)  # it was not asked for
    seen.press("Fly it")  # which it cannot be before the page knows its flight
    seen.wait_for_text("The mission is flown from now on")
    assert tuple(flight.steering.parameters(SIMULATOR)["wind"]) == (3.0, -4.0, 0.0)
    assert "mission" not in seen.page.url
    seen.page.evaluate("(mission) => (location.hash = `mission=${mission}`)", mission)
    seen.wait_for_text("This address holds a mission")  # another link in the same tab
    seen.press("Not now")


@pytest.mark.nodes
@pytest.mark.long
def test_a_killed_node_shows_the_fallback_and_then_the_recovery(look, tmp_path):
    """The same with nodes as processes: the page hears of it over ROS topics.

    Nothing holds up a flight of nodes while its page is drawn, hence the words that stay: that it
    has recovered is told of what was seen to fall back, and the history says from what, and why.
    What the page heard first is a matter of milliseconds: that no command comes, or what the new
    controller waits for.
    """
    pytest.importorskip("rclpy", reason="needs ROS 2")

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
        seen.page.get_by_text(re.compile(r"History: \d+ fallback")).first.click()  # it is folded
        lost = "|".join(mode.value for mode in FallbackMode if not mode.nominal)
        seen.wait_for_text(re.compile(rf"\d s ({lost})\s+\w+"))
        assert seen.errors == []
    finally:
        process.send_signal(signal.SIGTERM)
        process.wait()
