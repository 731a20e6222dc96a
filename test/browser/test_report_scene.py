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

import numpy as np
import pytest
from PIL import Image

from uav_tracking_mpc.report.mission_report import write_report

pytestmark = [pytest.mark.browser, pytest.mark.timeout(900)]

NEXT_FRAMES = "() => new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))"


def same(one, other):
    """But for a handful of pixels at the edge of the slider."""
    return np.count_nonzero(np.abs(one - other).max(axis=2) > 8) < 20


@pytest.fixture
def report(flight, tmp_path):
    """Address of the report of a flight, as a file."""
    from uav_tracking_mpc.view.recorded.recorded_scene import recorded_scene

    log, _ = flight
    write_report(log, tmp_path, recorded_scene)
    return (tmp_path / "report.html").as_uri()


def test_it_waits_then_plays_then_goes_where_it_is_sent(look, report):
    """Nothing is loaded before it is opened, nothing from elsewhere after it."""
    seen = look(report, ready=False)
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
        def stands():  # a frame that was under way may move it on once more
            time.fill(f"{second}")
            scene.locator("body").evaluate(NEXT_FRAMES)
            return float(time.input_value()) == pytest.approx(second)

        seen.eventually(stands, "it stands where it was sent")
        pictures = [picture(), picture()]
        seen.eventually(
            lambda: pictures.append(picture()) or (same(*pictures[-2:]) and same(*pictures[-3:-1])),
            "the scene stands still",
        )
        assert float(time.input_value()) == pytest.approx(second)
        return pictures[-1]

    def comes_back():
        first, later, again = stand_at(2.0), stand_at(15.0), stand_at(2.0)
        return same(first, again) and not same(first, later)

    seen.eventually(comes_back, "each time has its picture")
    assert seen.errors == []
    asked = [each for each in seen.requests if not each.startswith(("data:", "blob:"))]
    assert asked == [report]


def test_it_is_gone_when_it_is_closed(look, report):
    """So that an open report costs nothing."""
    seen = look(report, ready=False)
    title, scene = seen.page.get_by_text("Play the flight"), seen.page.frame_locator("iframe")
    title.click()
    scene.locator("canvas").first.wait_for(state="visible")
    title.click()
    seen.eventually(lambda: scene.locator("canvas").count() == 0, "nothing is drawn")
