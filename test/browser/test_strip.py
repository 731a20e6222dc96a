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

"""Title, banner, head-up display, either way round and phone: all that a page shows of a flight."""

import math

import numpy as np
import pytest
from seen_page import SeenPage
from watched_flight_stand_in import StandInFlight, StandInSource, sight

from uav_tracking_mpc import load_configuration
from uav_tracking_mpc.control.fallback import FallbackMode
from uav_tracking_mpc.dynamics.orbit import FlownOrbit
from uav_tracking_mpc.view.page import COLOURS
from uav_tracking_mpc.view.watched_flight import CONTROLLER, SILENT, NodeStatus

pytestmark = pytest.mark.browser


class Flight(StandInFlight):
    tracking = load_configuration("small_uav").controller


@pytest.fixture(scope="module")
def source():
    return StandInSource(Flight())


@pytest.fixture(scope="module")
def opened(context, page):
    """The page that tests share, with pixels enough for dashes."""
    return SeenPage(context.new_page(), page.address, resolution=0.5)


@pytest.fixture
def flight(source):
    """As it was first."""
    source.aircraft[0].seen[:] = [sight()]
    return source.aircraft[0]


@pytest.fixture
def seen(opened, flight):
    return opened


def test_title_icon_and_colours_are_its_own(seen):
    for scheme in ("dark", "light"):
        seen.page.emulate_media(color_scheme=scheme)
        seen.page.locator(f"html[data-mantine-color-scheme={scheme}]").wait_for()
    seen.eventually(lambda: "· aircraft ·" in seen.page.title(), "the title names the flight")
    assert "optimal plan" in seen.page.title()
    icons = seen.page.locator("link[rel=icon]")
    assert icons.count() == 1
    assert icons.get_attribute("href").startswith("data:image/svg+xml")
    assert seen.errors == [] and seen.foreign_requests == []


def test_a_silent_controller_is_announced_until_it_speaks(seen, flight):
    banner = seen.page.locator("#flight-banner")
    banner.wait_for(state="hidden")
    silent = (NodeStatus(CONTROLLER, SILENT, "killed"), NodeStatus("uav_simulator", 0, "ok"))
    flight.seen.append(sight(11.0, mode=FallbackMode.SILENCE, statuses=silent))
    seen.wait_for_element("#flight-banner", "The controller is silent: killed")
    flight.seen.append(sight(12.0))
    banner.wait_for(state="hidden")


def test_a_picture_that_is_old_says_how_old_until_it_is_drawn_again(seen, page, monkeypatch):
    def fail():
        raise ZeroDivisionError("of the page")

    with monkeypatch.context() as patch:
        patch.setattr(page, "draw", fail)
        seen.wait_for_element("#flight-banner", "the picture is")
    seen.page.locator("#flight-banner").wait_for(state="hidden")


def test_the_head_up_display_agrees_with_the_state(seen, flight):
    """A bank to the left, as it is first, turns the horizon clockwise."""
    seen.page.keyboard.press("h")
    for name, words in (
        ("airspeed", "22.5 m/s"),
        ("altitude", "121.0 m"),
        ("range", "range error +0.4 m"),
        ("mode", "optimal plan"),
        ("bank", "bank 11.5° left, limit 45°"),
    ):
        seen.wait_for_element(f"[data-hud={name}]", words)
    flight.seen.append(sight(11.0, bank=math.radians(30.0)))
    seen.wait_for_element("[data-hud=bank]", "bank 30.0° right")
    horizon = seen.page.locator("[data-hud=horizon]").get_attribute("transform")
    assert float(horizon.removeprefix("rotate(").rstrip(")")) == pytest.approx(-30.0, abs=0.01)
    nothing = {"airspeed": math.nan, "bank": math.nan, "target": None, "errors": {}}
    flight.seen.append(sight(12.0, **nothing))
    for words in ("airspeed not known", "attitude not known"):
        seen.wait_for_element("#flight-hud text", words)
    assert "NaN" not in seen.page.locator("#flight-hud").inner_html()
    seen.page.keyboard.press("h")
    seen.page.locator("#flight-hud").wait_for(state="hidden")
    assert seen.errors == []


def test_the_cockpit_has_the_display_and_the_other_views_have_none(seen):
    for view, state in (("from the cockpit", "visible"), ("the orbit", "hidden")):
        seen.page.get_by_role("combobox", name="Camera").click()
        seen.page.get_by_role("option", name=view, exact=True).click()
        seen.page.locator("#flight-hud").wait_for(state=state)


def test_keys_belong_to_the_page_again_after_a_choice_from_a_list(seen):
    camera = seen.page.get_by_role("combobox", name="Camera")
    hud = seen.page.locator("#flight-hud")
    camera.click()
    seen.page.get_by_role("option", name="follow", exact=True).click()
    seen.eventually(lambda: camera.evaluate("it => it !== document.activeElement"), "it has closed")
    for state in ("visible", "hidden"):
        seen.page.keyboard.press("h")
        hud.wait_for(state=state)
    assert camera.input_value() == "follow"
    camera.click()
    seen.page.get_by_role("option", name="the orbit", exact=True).click()


def test_the_orbit_that_is_asked_for_is_seen_either_way_round(seen, flight):
    """Half of its dashed circle has the aircraft's colour, and the circle inside of it none."""
    turn = np.linspace(0.0, 2.0 * np.pi, 120, endpoint=False)
    circle = np.stack([np.cos(turn), np.sin(turn), np.zeros_like(turn)], axis=1)
    centre, time = np.array([0.0, 0.0, 120.0]), 10.0
    for radius in (-275.0, 275.0):
        pixels, time = seen.still_pixels(), time + 1.0
        flight.seen.append(sight(time, wanted=FlownOrbit(centre, np.zeros(3), radius, 22.0)))
        seen.pixels_unlike(pixels)
        pixels, shares = seen.still_pixels(), []
        for size in (1.0, 0.85):
            places = seen.pixel_of(centre + size * abs(radius) * circle).round().astype(int)
            near = [pixels[row - 2 : row + 2, column - 2 : column + 2] for column, row in places]
            away = [np.abs(place - COLOURS[0]).max(axis=2).min(initial=255) for place in near]
            shares.append(np.mean(np.array(away) < 60))
        assert shares[0] > 0.3
        assert shares[1] < 0.05


def test_a_page_that_pauses_stands_while_the_flight_goes_on_and_plays_on(seen, flight):
    flight.seen[:] = [sight(10.0 + 0.2 * k) for k in range(20)]
    seen.wait_for_element("#flight-time", "0:13.8")
    seen.page.get_by_role("button", name="pause", exact=True).first.press("Enter")
    seen.wait_for_element("#flight-words", "The picture is of the past: 0.0 s before now")
    flight.seen.append(sight(20.0))
    seen.wait_for_element("#flight-words", "The picture is of the past: 6.2 s before now")
    assert seen.page.locator("#flight-time").text_content() == "0:13.8"
    seen.page.keyboard.press("Enter")  # the button keeps the keys: it says "play" now
    seen.wait_for_element("#flight-time", "0:20.0")  # it has caught up
    seen.page.locator("body:not(.flight-past)").wait_for()


def test_on_a_phone_panel_and_strip_are_folded_and_unfold(chromium, page):
    context = chromium.new_context(viewport={"width": 390, "height": 800})
    seen = SeenPage(context.new_page(), page.address, ready=False)
    strip, canvas = (seen.page.locator(f"#flight-strip{part}") for part in ("", " canvas"))
    strip.wait_for(state="visible")
    assert strip.bounding_box()["height"] < 45
    assert strip.bounding_box()["width"] == 390
    canvas.wait_for(state="hidden")
    seen.page.get_by_title("Fold or unfold").click()
    canvas.wait_for(state="visible")
    assert strip.bounding_box()["height"] > 90
    fold = seen.page.get_by_title("Fold or unfold").bounding_box()
    assert fold["x"] + fold["width"] < 390  # so that it can be folded again
    assert seen.page.evaluate("document.documentElement.scrollWidth") == 390
    camera = seen.page.get_by_text("Camera", exact=True)
    camera.wait_for(state="attached")
    camera.wait_for(state="hidden")
    seen.page.get_by_text("uav_tracking", exact=True).click()
    camera.wait_for(state="visible")
    seen.eventually(lambda: "aircraft" in seen.page.title(), "the script has asked again")
    assert camera.is_visible()
    context.close()


def test_a_real_flight_has_the_time_of_day(seen, flight):
    """Its clock counts from 1970: hours since then say nothing."""
    flight.seen[:] = [sight(1_764_180_000.5)]
    seen.wait_for_element("#flight-time", "18:00:00.5")
