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

"""The pictures of docs/gallery.md: `make gallery` flies, shows the page to a browser, takes them.

The flight is simulated once and shown from its log. Its clock stands for each picture, so that a
machine without a graphics card, which draws one or two frames a second, takes the same pictures.
Needs chromium, and playwright of the extra `[test]`.
"""

from __future__ import annotations

import io
import os
import shutil
import sys
import tempfile
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from PIL import Image
from playwright.sync_api import Browser, Page, sync_playwright

from uav_tracking_mpc import load_configuration, simulate
from uav_tracking_mpc.report.mission_report import write_report
from uav_tracking_mpc.simulation.flight_log import FlightLog
from uav_tracking_mpc.view.page import Page as LivePage
from uav_tracking_mpc.view.recorded_scene import LoggedSource, recorded_scene

FOLDER = Path(__file__).parent / "gallery"
SCENARIO = "circling_target"
PATIENCE = 300_000.0  # ms
FLAGS = ("--disable-background-networking", "--disable-gpu", "--no-first-run", "--no-proxy-server")
WIDE, TALL = (1200, 700), (390, 780)  # pixels
# Of the moving picture: from the approach to the orbit.
BEGIN, END, FRAMES, FRAME_TIME = 8.0, 48.0, 60, 120  # s, s, -, ms
MOVING = (800, 468)  # pixels
AT = 32.0  # s, at which stills are taken
SHOTS = 12  # at most, until two are the same
# The page says so where it is drawn without a graphics card.
QUIET = ".mantine-Notification-root { display: none !important; }"
COLOURS = 256  # of a still: it stays small


class Gallery:
    """Takes pictures of the page of one flight.

    Args:
        log: Of the flight, with its parameters.
        browser: That shows it.
    """

    def __init__(self, log: FlightLog, browser: Browser) -> None:
        self._browser = browser
        assert log.tracking is not None
        self._source = LoggedSource(log, log.tracking)
        self._source.clock.pause()
        self._source.clock.seek(AT)
        self._page = LivePage(self._source, port=0)
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._page.serve, args=(self._ended.is_set,))
        self._thread.start()

    def close(self) -> None:
        """Stop serving."""
        self._ended.set()
        self._thread.join()
        self._page.close()

    @contextmanager
    def tab(self, size: tuple[int, int]) -> Iterator[Page]:
        """The page in a tab of its own.

        Args:
            size: Width and height in pixels.
        """
        width, height = size
        context = self._browser.new_context(viewport={"width": width, "height": height})
        tab = context.new_page()
        tab.set_default_timeout(PATIENCE)
        tab.goto(self._page.address)
        tab.locator("canvas").first.wait_for(state="visible")
        tab.get_by_label("Camera", exact=True).first.wait_for(state="attached")  # phones fold it
        yield tab
        context.close()

    def still(self, tab: Page, name: str) -> None:
        """One picture.

        Args:
            tab: That shows it.
            name: Of its file.
        """
        save_still(settled(tab), name)

    def moving(self, tab: Page, name: str) -> None:
        """A moving picture, frame by frame.

        Args:
            tab: That shows it.
            name: Of its file.
        """
        pictures = []
        for time in np.linspace(BEGIN, END, FRAMES):
            self._source.clock.seek(float(time))
            pictures.append(settled(tab).resize(MOVING, Image.Resampling.LANCZOS))
        self._source.clock.seek(AT)
        first, *others = pictures
        options = {"duration": FRAME_TIME, "loop": 0, "quality": 60, "method": 6}
        first.save(FOLDER / name, save_all=True, append_images=others, **options)


def settled(tab: Page) -> Image.Image:
    """A picture once two in a row are the same: what was sent is drawn then.

    Args:
        tab: That shows it.
    """
    shots = [b""]
    while len(shots) < SHOTS and shots[-1] not in shots[:-1]:
        tab.wait_for_timeout(300.0)
        shots.append(tab.screenshot(animations="disabled", style=QUIET))
    return Image.open(io.BytesIO(shots[-1])).convert("RGB")


def save_still(picture: Image.Image, name: str) -> None:
    """Write a still.

    Args:
        picture: What is seen.
        name: Of its file.
    """
    few = picture.quantize(COLOURS, Image.Quantize.MAXCOVERAGE, kmeans=2, dither=Image.Dither.NONE)
    few.save(FOLDER / name, optimize=True)


def choose(tab: Page, option: str) -> None:
    """Choose a camera of the page.

    Args:
        tab: That shows the page.
        option: Its name in the list.
    """
    tab.get_by_label("Camera", exact=True).first.click()
    tab.get_by_role("option", name=option, exact=True).click()


def report_scene(log: FlightLog, browser: Browser) -> None:
    """The report of the flight on a dark page, its scene open.

    Args:
        log: Of the flight.
        browser: That shows it.
    """
    width, height = WIDE
    with tempfile.TemporaryDirectory() as folder:
        write_report(log, Path(folder), recorded_scene)
        shutil.copy(Path(folder) / "conditions.png", FOLDER / "conditions.png")
        context = browser.new_context(
            viewport={"width": width, "height": height}, color_scheme="dark"
        )
        tab = context.new_page()
        tab.set_default_timeout(PATIENCE)
        tab.goto((Path(folder) / "report.html").as_uri())
        tab.get_by_text("Play the flight").click()
        scene = tab.frame_locator("iframe")
        scene.locator("canvas").first.wait_for(state="visible")
        scene.locator("input").first.fill(f"{AT}")
        tab.evaluate("document.querySelector('details.scene').scrollIntoView()")
        save_still(settled(tab), "report.png")
        context.close()


def main() -> None:
    """Take all pictures."""
    chromium = os.environ.get("CHROMIUM") or shutil.which("chromium")
    if chromium is None:
        sys.exit("make gallery needs chromium: apt-get install chromium")
    FOLDER.mkdir(exist_ok=True)
    log = simulate(load_configuration("small_uav", scenario=SCENARIO))
    with sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=chromium, args=list(FLAGS))
        gallery = Gallery(log, browser)
        try:
            with gallery.tab(WIDE) as tab:
                gallery.still(tab, "page.png")
                for view, name in (("from above", "above"), ("follow", "follow")):
                    choose(tab, view)
                    gallery.still(tab, f"{name}.png")
                choose(tab, "the orbit")
                tab.get_by_label("Dark", exact=True).check()
                gallery.still(tab, "dark.png")
            with gallery.tab(TALL) as tab:
                gallery.still(tab, "phone.png")
            report_scene(log, browser)
            with gallery.tab(WIDE) as tab:
                gallery.moving(tab, "page.webp")
        finally:
            gallery.close()
        browser.close()


if __name__ == "__main__":
    main()
