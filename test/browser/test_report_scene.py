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

"""The moving scene of a report, opened from a file as from a mail."""

import io
from itertools import pairwise

import numpy as np
import pytest
from PIL import Image
from seen_page import SeenPage

from uav_tracking_mpc.report.mission_report import write_report

pytestmark = pytest.mark.browser

NEXT_FRAMES = "() => new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))"


def same(one, other):
    """But for a handful of pixels at the edge of the slider."""
    return np.count_nonzero(np.abs(one - other).max(axis=2) > 8) < 20


@pytest.fixture(scope="module")
def report(flight, tmp_path_factory):
    """Address of the report of a flight, as a file."""
    from uav_tracking_mpc.view.recorded_scene import recorded_scene

    log, _ = flight
    folder = tmp_path_factory.mktemp("report")
    write_report(log, folder, recorded_scene)
    return (folder / "report.html").as_uri()


@pytest.fixture(scope="module")
def seen(context, report):
    """The report, which both tests read."""
    tab = context.new_page()
    tab.set_viewport_size({"width": 600, "height": 400})
    return SeenPage(tab, report, ready=False)


def test_it_waits_then_plays_then_goes_where_it_is_sent(seen, report):
    """Nothing is loaded before it is opened, nothing from elsewhere after it."""
    frame, scene = seen.page.locator("details.scene iframe"), seen.page.frame_locator("iframe")
    assert scene.locator("canvas").count() == 0
    seen.page.get_by_text("Play the flight").click()
    scene.locator("canvas").first.wait_for(state="visible")
    time = scene.locator("input").first
    seen.eventually(lambda: float(time.input_value()) > 0.0, "it plays")

    def picture():
        """After the scene has had time to draw what it knows: it draws seldom and late."""
        scene.locator("body").evaluate(NEXT_FRAMES)
        drawn = Image.open(io.BytesIO(frame.screenshot())).convert("RGB")
        return np.asarray(drawn, dtype=np.int16)

    def stand_at(second):
        pictures = []

        def is_there():
            return float(time.input_value()) == pytest.approx(second)

        def stands():
            if not is_there():  # a frame that was under way may move it on once more
                time.fill(f"{second}")
                pictures.clear()
            pictures.append(picture())
            still = all(same(*pair) for pair in pairwise(pictures[-3:]))
            return is_there() and len(pictures) > 2 and still

        seen.eventually(stands, "the scene stands still where it was sent")
        return pictures[-1]

    def comes_back():  # a page that draws slowly takes fewer pixels from some moment on
        first, later, again = stand_at(2.0), stand_at(15.0), stand_at(2.0)
        return same(first, again) and not same(first, later)

    seen.eventually(comes_back, "each time has its picture")
    assert seen.errors == []
    asked = [each for each in seen.requests if not each.startswith(("data:", "blob:"))]
    assert asked == [report]


def test_the_strip_goes_with_the_replay_and_sends_it_elsewhere(seen):
    title, scene = seen.page.get_by_text("Play the flight"), seen.page.frame_locator("iframe")
    if scene.locator("canvas").count() == 0:  # without the test above
        title.click()
    canvas, time = scene.locator("#flight-strip canvas"), scene.locator("input").first
    scene.get_by_title("Fold or unfold").press("Enter")
    canvas.wait_for(state="visible")
    seen.eventually(lambda: int(canvas.get_attribute("data-rows") or 0) > 15, "it has its rows")
    time.fill("3")  # and stands
    scene.locator("#flight-time", has_text="0:03.0").wait_for()
    canvas.press("PageUp")
    scene.locator("#flight-time", has_text="0:13.0").wait_for()
    assert float(time.input_value()) == 13.0
    assert "paper" in scene.locator("title").first.text_content()
    assert seen.errors == []


def test_it_is_gone_when_it_is_closed(seen):
    """So that an open report costs nothing."""
    title, scene = seen.page.get_by_text("Play the flight"), seen.page.frame_locator("iframe")
    if scene.locator("canvas").count() == 0:  # without the test above
        title.click()
    scene.locator("canvas").first.wait_for(state="visible")
    title.click()
    seen.eventually(lambda: scene.locator("canvas").count() == 0, "nothing is drawn")
