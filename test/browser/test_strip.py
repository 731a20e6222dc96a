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

"""Title, banner, time strip and head-up display of the live page, in a real browser."""

import math

import numpy as np
import pytest
from seen_page import PageProcess, SeenPage, save_flight, served
from watched_flight_stand_in import StandInFlight, StandInSource, sight

from uav_tracking_mpc import load_configuration
from uav_tracking_mpc.control.fallback import FallbackMode
from uav_tracking_mpc.view.watched_flight import CONTROLLER, SILENT, NodeStatus

pytestmark = [pytest.mark.browser, pytest.mark.timeout(900)]

LINE = """canvas => {
    const data = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data;
    let blue = 0;
    for (let k = 0; k < data.length; k += 4) blue += data[k + 2] > data[k] + 60;
    return blue;
}"""  # pixels in the colour of the lines


class Flight(StandInFlight):
    tracking = load_configuration("small_uav").controller


@pytest.fixture(scope="module")
def source():
    return StandInSource(Flight())


@pytest.fixture
def seen(opened, source):
    """The page that tests share, its flight as it was first."""
    source.aircraft[0].seen[:] = [sight()]
    return opened


def wait_for(seen, selector, words):
    seen.page.locator(selector, has_text=words).first.wait_for(state="visible")


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_title_icon_and_colours_are_its_own(chromium, page, scheme):
    context = chromium.new_context(color_scheme=scheme)
    seen = SeenPage(context.new_page(), page.address, ready=False)
    seen.page.locator(f"html[data-mantine-color-scheme={scheme}]").wait_for()
    seen.eventually(lambda: "aircraft" in seen.page.title(), "the title names the flight")
    assert "optimal plan" in seen.page.title()
    icons = seen.page.locator("link[rel=icon]")
    assert icons.count() == 1
    assert icons.get_attribute("href").startswith("data:image/svg+xml")
    assert seen.errors == [] and seen.foreign_requests == []
    context.close()


def test_a_silent_controller_is_announced_until_it_speaks(seen, source):
    flight = source.aircraft[0]
    banner = seen.page.locator("#flight-banner")
    banner.wait_for(state="hidden")
    silent = (NodeStatus(CONTROLLER, SILENT, "killed"), NodeStatus("uav_simulator", 0, "ok"))
    flight.seen.append(sight(11.0, mode=FallbackMode.SILENCE, statuses=silent))
    wait_for(seen, "#flight-banner", "The controller is silent: killed")
    flight.seen.append(sight(12.0))
    banner.wait_for(state="hidden")


def test_a_picture_that_is_old_says_how_old_until_it_is_drawn_again(seen, page, monkeypatch):
    def fail():
        raise ZeroDivisionError("of the page")

    with monkeypatch.context() as patch:
        patch.setattr(page, "draw", fail)
        wait_for(seen, "#flight-banner", "the picture is")
    seen.page.locator("#flight-banner").wait_for(state="hidden")


def test_a_server_that_dies_is_announced_and_its_successor_asks_for_its_address(
    look, flight, tmp_path
):
    saved = save_flight(*flight, tmp_path / "flight.pickle")
    with PageProcess(saved) as process:
        seen = look(process.address)
        seen.eventually(lambda: seen.page.title().startswith("optimal"), "the title says the mode")
        process.kill()
        wait_for(seen, "#flight-banner", "Connection lost: the picture is")
        with PageProcess(saved, process.port):
            wait_for(seen, "#flight-banner", "Open the address that it prints")


def test_the_head_up_display_agrees_with_the_state(seen, source):
    """A bank to the left, as it is first, turns the horizon clockwise."""
    seen.page.keyboard.press("h")
    wait_for(seen, "[data-hud=airspeed]", "22.5 m/s")
    wait_for(seen, "[data-hud=height]", "121.0 m")
    wait_for(seen, "[data-hud=range]", "range error +0.4 m")
    wait_for(seen, "[data-hud=mode]", "optimal plan")
    wait_for(seen, "[data-hud=bank]", "bank 11.5° left, limit 45°")
    source.aircraft[0].seen.append(sight(11.0, bank=math.radians(30.0)))
    wait_for(seen, "[data-hud=bank]", "bank 30.0° right")
    horizon = seen.page.locator("[data-hud=horizon]").get_attribute("transform")
    assert float(horizon.removeprefix("rotate(").rstrip(")")) == pytest.approx(-30.0, abs=0.01)
    seen.page.keyboard.press("h")
    seen.page.locator("#flight-hud").wait_for(state="hidden")


def test_a_display_of_what_is_not_known_says_so(seen, source):
    nothing = {"airspeed": math.nan, "bank": math.nan, "target": None, "errors": {}}
    source.aircraft[0].seen.append(sight(11.0, **nothing))
    seen.page.keyboard.press("h")
    wait_for(seen, "#flight-hud text", "airspeed not known")
    wait_for(seen, "#flight-hud text", "attitude not known")
    assert "NaN" not in seen.page.locator("#flight-hud").inner_html()
    seen.page.keyboard.press("h")
    assert seen.errors == []


def test_the_cockpit_has_the_display_and_the_other_views_have_none(seen):
    def choose(view):
        seen.page.get_by_role("combobox", name="Camera").click()
        seen.page.get_by_role("option", name=view, exact=True).click()

    choose("from the cockpit")
    wait_for(seen, "[data-hud=airspeed]", "m/s")
    choose("the orbit")
    seen.page.locator("#flight-hud").wait_for(state="hidden")


@pytest.fixture(scope="module")
def recorded(flight):
    from uav_tracking_mpc.view.recorded_scene import LoggedSource

    source = LoggedSource(*flight)
    source.clock.pause()
    source.clock.seek(14.0)
    with served(source) as page:
        yield page


def test_one_page_goes_back_and_comes_again_while_the_other_stays(look, recorded):
    other, seen = look(recorded.address), look(recorded.address)
    if seen.page.locator("#flight-strip.folded").count():
        seen.page.get_by_title("Fold or unfold").click()
    canvas = seen.page.locator("#flight-strip canvas")
    seen.eventually(lambda: int(canvas.get_attribute("data-rows") or 0) > 15, "the strip has rows")
    seen.eventually(lambda: canvas.evaluate(LINE) > 200, "its lines are drawn")
    wait_for(seen, "#flight-time", "0:14.0")
    now = seen.still_pixels()
    stays = other.still_pixels()
    canvas.focus()
    for _ in range(2):
        canvas.press("PageDown")  # 10 s back each, no farther than the begin
    wait_for(seen, "#flight-time", "0:00.0")
    wait_for(seen, "#flight-words", "The picture is of the past")
    wait_for(seen, "#flight-card", "Airspeed")
    seen.page.get_by_text("limits").first.wait_for(state="hidden")  # the readings of now
    seen.eventually(lambda: seen.page.title().startswith("past"), "the title says so")
    past = seen.pixels_unlike(now)
    assert other.page.locator("#flight-time").text_content() == "0:14.0"
    assert np.array_equal(other.still_pixels(), stays)
    seen.page.get_by_role("button", name="live", exact=True).click()
    wait_for(seen, "#flight-time", "0:14.0")
    again = seen.pixels_unlike(past)
    assert seen.page.locator("body.flight-past").count() == 0
    seen.eventually(lambda: np.array_equal(seen.still_pixels(), now), "it is as it was")
    assert again.shape == now.shape
    assert seen.errors == []


def test_a_page_that_pauses_stands_while_the_flight_goes_on_and_plays_on(seen, source):
    flight = source.aircraft[0]
    flight.seen[:] = [sight(10.0 + 0.2 * k) for k in range(20)]
    wait_for(seen, "#flight-time", "0:13.8")
    seen.page.get_by_role("button", name="pause", exact=True).first.click()
    wait_for(seen, "#flight-words", "The picture is of the past: 0.0 s before now")
    flight.seen.append(sight(20.0))
    wait_for(seen, "#flight-words", "The picture is of the past: 6.2 s before now")
    assert seen.page.locator("#flight-time").text_content() == "0:13.8"
    seen.page.get_by_role("button", name="play", exact=True).first.click()
    wait_for(seen, "#flight-time", "0:20.0")  # it has caught up
    seen.page.locator("body:not(.flight-past)").wait_for()


def test_on_a_phone_the_strip_is_folded_and_unfolds(chromium, page):
    context = chromium.new_context(viewport={"width": 390, "height": 800})
    seen = SeenPage(context.new_page(), page.address, ready=False)
    strip = seen.page.locator("#flight-strip")
    strip.wait_for(state="visible")
    assert strip.bounding_box()["height"] < 45
    assert strip.bounding_box()["width"] == 390
    seen.page.locator("#flight-strip canvas").wait_for(state="hidden")
    seen.page.get_by_title("Fold or unfold").click()
    seen.page.locator("#flight-strip canvas").wait_for(state="visible")
    assert strip.bounding_box()["height"] > 90
    assert seen.page.evaluate("document.documentElement.scrollWidth") == 390
    context.close()


def test_on_a_phone_the_panel_begins_folded_and_its_head_unfolds_it(chromium, page):
    context = chromium.new_context(viewport={"width": 390, "height": 800})
    seen = SeenPage(context.new_page(), page.address, ready=False)
    camera = seen.page.get_by_text("Camera", exact=True)
    camera.wait_for(state="attached")
    camera.wait_for(state="hidden")
    seen.page.get_by_text("uav_tracking", exact=True).click()
    camera.wait_for(state="visible")
    seen.eventually(lambda: "aircraft" in seen.page.title(), "the script has asked again")
    assert camera.is_visible()
    context.close()
