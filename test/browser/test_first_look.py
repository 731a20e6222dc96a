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

"""What a stranger sees at first, finds without scrolling, and takes along."""

import io

import numpy as np
import pytest
from PIL import Image
from seen_page import SeenPage, served

from uav_tracking_mpc.settings.configuration import load_configuration
from uav_tracking_mpc.view.watched_flight import CONTROLLER, SIMULATOR

pytestmark = [pytest.mark.browser, pytest.mark.timeout(900)]

SCREEN = {"width": 1280, "height": 800}


@pytest.fixture(scope="module")
def source():
    """``small_uav`` by a law that is quick to fly; time stands after the first second."""
    from uav_tracking_mpc.view.simulated_source import SimulatedSource

    overrides = ["mission.speed=1.0", "nmpc_controller.law=l1"]
    source = SimulatedSource(load_configuration("small_uav", overrides, "crosswind"))
    yield source
    source.close()


@pytest.fixture(scope="module")
def seen(chromium, source):
    """The page that tests share."""
    context = chromium.new_context(viewport=SCREEN, accept_downloads=True)
    with served(source) as page:
        # In as many pixels as it has: a page of few is a small one, on which the legend is folded.
        yield SeenPage(context.new_page(), page.address, resolution=1.0)
    context.close()


def box(seen, words, exact=True):
    """Where words stand on the page."""
    found = []

    def stands():  # what is written anew in that moment stands nowhere
        found.append(seen.page.get_by_text(words, exact=exact).first.bounding_box())
        return found[-1] is not None

    seen.eventually(stands, f"{words} is seen")
    return found[-1]


def test_the_orbit_is_in_the_middle_of_what_the_panel_leaves(seen, source):
    (flight,) = source.flights()
    panel = box(seen, "Orbit")
    # The scene moves with the target: where the first view looks, its middle stays.
    column, row = seen.pixel_of((0.0, 0.0, 60.0))
    assert abs(column - 0.5 * (panel["x"] - 20.0)) < 30.0
    assert 0.3 * SCREEN["height"] < row < 0.7 * SCREEN["height"]
    assert flight.sight.wanted is not None


def test_a_legend_says_what_is_seen_and_how_the_target_is_moved(seen):
    for words in (
        "the plan: where it flies next",
        "the orbit that is asked for",
        "Drag the target",
    ):
        assert box(seen, words)["x"] < 300.0
    assert seen.errors == []


def test_the_legend_makes_room_for_the_head_up_display(seen):
    legend = seen.page.get_by_text("the plan: where it flies next")
    seen.page.get_by_role("button", name="HUD", exact=True).press("Enter")
    legend.wait_for(state="hidden")
    assert seen.page.get_by_text("Orbit", exact=True).first.is_visible()
    seen.page.get_by_role("button", name="HUD", exact=True).press("Enter")
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


def test_a_refusal_stands_where_the_value_was_typed(seen, source):
    (flight,) = source.flights()
    refusal = flight.steering.change(CONTROLLER, range=40.0)
    seen.enter("range [m]", 40.0, lambda: seen.shows(refusal))
    seen.eventually(lambda: flight.tracking.range == seen.entered("range [m]"), "it goes back")
    said = box(seen, refusal, False)["y"]
    assert box(seen, "range [m]")["y"] < said < box(seen, "altitude [m]")["y"]


def test_the_classical_laws_fly_beside_when_asked_for(seen, source):
    (flight,) = source.flights()
    seen.page.get_by_role("checkbox").first.wait_for(state="attached")
    seen.row("classical laws").locator("input").check(force=True)
    seen.wait_for_text("RMS, last minute")
    assert {rival.law for rival in flight.sight.rivals} >= {"l1", "npfg", "vector_field"}
    seen.row("classical laws").locator("input").uncheck(force=True)
    seen.eventually(lambda: not flight.sight.rivals, "they end")


def test_a_picture_and_the_mission_are_saved(seen, source):
    (flight,) = source.flights()
    with seen.page.expect_download() as saving:
        seen.press("Save a picture")
    saved = saving.value
    assert saved.suggested_filename == "flight.png"
    with open(saved.path(), "rb") as file:
        picture = np.asarray(Image.open(io.BytesIO(file.read())).convert("RGB"))
    assert picture.std() > 1.0  # something is drawn upon it
    flight.steering.change(SIMULATOR, wind=(3.0, -4.0, 0.0))
    seen.page.get_by_text("Mission file", exact=True).click()
    with seen.page.expect_download() as saving:
        seen.press("Save mission")
    mission = load_configuration("small_uav", scenario=str(_yaml(saving.value)))
    assert mission.simulator.wind == (3.0, -4.0, 0.0)
    assert mission.controller.range == flight.tracking.range


def _yaml(download):
    path = download.path().with_suffix(".yaml")
    download.save_as(path)
    return path
