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

"""A page as a browser shows it, for tests with the marker ``browser``.

The fixture ``look`` (test/browser/conftest.py) opens pages and closes them after the test.
``served(source)`` serves any source in this process, so that the test can turn its clock or ask its
flights; ``PageProcess`` serves a log in a process of its own, which can die and come back::

    def test_something(look, flight):          # flight: (log, tracking) of 20 s with `paper`
        source = LoggedSource(*flight)
        source.clock.pause()
        with served(source) as page:
            seen = look(page.address)  # waits until it is connected and draws
            before = seen.pixels()  # RGB of the scene, without the panel: (height, width, 3)
            source.clock.seek(10.0)
            after = seen.pixels_unlike(before)  # waits until there is a change
            place = seen.pixel_of((0.0, 0.0, 0.0))  # of a point in `map`, through its camera
            seen.drag(place, seen.pixel_of((100.0, 50.0, 0.0)))  # the mouse, pixel to pixel
            seen.wait_for_text("refused")  # in the panel or a notice
            assert seen.errors == [] and seen.foreign_requests == []

A pixel that lies beneath the panel belongs to the panel: the mouse reaches the scene beside it.
``seen.page`` is playwright's page, for all else (``seen.page.get_by_role("slider")``, ``click``).
To open a page costs more than most that is done with it: tests of one file share one, where it can
be put back to what each begins with.

Chromium draws one or two frames a second where it has no graphics card: wait for what must come
(``eventually``), never for a time, and assert nothing about times. Such a page may never show what
holds for some seconds alone: let the flight stand meanwhile, or wait for words that stay.

The scene is drawn with few pixels, since a processor draws them; ``look(address, resolution=1.0)``
draws one for each of the page's. Either way it stays so: left to itself, a page draws fewer where
it is slow, and no two pictures would be the same.
"""

from __future__ import annotations

import contextlib
import io
import math
import pickle
import re
import subprocess
import sys
import threading
import time
from pathlib import Path
from unittest import mock
from urllib.parse import urlsplit

import msgspec
import numpy as np
from PIL import Image

PATIENCE = 180.0  # s: a limit for what is broken, not a measure of what works
FRAME_PERIOD = 0.5  # s: a browser without a graphics card draws hardly more of them
CLOSE, FEW = (
    24,
    0.003,
)  # levels of 255, share of pixels: what two pictures of one scene may differ by


@contextlib.contextmanager
def served(source, host=None):
    """A page of a source, drawn by a thread; both are closed at the end.

    The scene stands at once: the turn of the first seconds is left out.
    """
    from uav_tracking_mpc.view.page import Page

    page, ended = Page(source, host, 0), threading.Event()
    thread = threading.Thread(target=page.serve, args=(ended.is_set,), daemon=True)
    with (
        mock.patch("uav_tracking_mpc.view.page.FRAME_PERIOD", FRAME_PERIOD),
        mock.patch("uav_tracking_mpc.view.cameras.OPENING", 0.0),
    ):
        thread.start()
        try:
            yield page
        finally:
            ended.set()
            thread.join(PATIENCE)
            page.close()


def save_flight(log, tracking, path):
    """Write a flight for :class:`PageProcess`."""
    path.write_bytes(pickle.dumps((log, tracking)))
    return path


class PageProcess:
    """A logged flight, played again and again, in a process of its own."""

    def __init__(self, flight: Path, port: int = 0) -> None:
        self._process = subprocess.Popen(
            [sys.executable, __file__, str(flight), str(port)], stdout=subprocess.PIPE, text=True
        )
        assert self._process.stdout is not None
        self.address = self._process.stdout.readline().strip()
        assert self.address.startswith("http://"), "the page's process did not start"
        self.port = urlsplit(self.address).port

    def kill(self) -> None:
        """As a crash or the loss of power would."""
        self._process.kill()
        self._process.wait()

    def __enter__(self) -> PageProcess:
        return self

    def __exit__(self, *_: object) -> None:
        self.kill()


def _main(flight: str, port: str) -> None:
    from uav_tracking_mpc.view.page import Page
    from uav_tracking_mpc.view.recorded_scene import LoggedSource

    source = LoggedSource(*pickle.loads(Path(flight).read_bytes()))
    page = Page(source, None, int(port))

    def play_on() -> bool:
        if not source.clock.playing:
            source.clock.play()
        return False

    print(page.address, flush=True)
    with mock.patch("uav_tracking_mpc.view.page.FRAME_PERIOD", FRAME_PERIOD):
        page.serve(play_on)


# Four frames a second at most: without a graphics card each keeps a processor from other tests.
FEWER_FRAMES = """
const next = window.requestAnimationFrame.bind(window);
window.requestAnimationFrame = (draw) => setTimeout(() => next(draw), 250);
window.cancelAnimationFrame = clearTimeout;
"""
SCENE = "canvas[data-engine]"  # three.js marks what it draws on; plots have canvases, too
SCENE_ALONE = (
    f"body * {{ visibility: hidden !important; }} {SCENE} {{ visibility: visible !important; }}"
)


class SeenPage:
    """A page in a tab of its own.

    Args:
        tab: Page of playwright, still empty.
        address: Of the page, with its token if it asks for one.
        ready: Whether to wait until the scene stands.
        resolution: Pixels that the scene is drawn with, by those of the page, along each axis [-].

    Attributes:
        page: Page of playwright.
        console: All that the page says in the browser's console.
        errors: Errors of the console, and exceptions of scripts.
        requests: Addresses of all requests and websockets.
    """

    def __init__(self, tab, address, ready=True, resolution=0.25) -> None:
        self.page, self.console, self.errors, self.requests = tab, [], [], []
        self._camera = None
        tab.set_default_timeout(1000.0 * PATIENCE)
        tab.add_init_script(FEWER_FRAMES)
        tab.on("console", self._note_console)
        tab.on("pageerror", lambda error: self.errors.append(str(error)))
        tab.on("request", lambda request: self.requests.append(request.url))
        tab.on("websocket", self._note_websocket)
        self._resolution = resolution
        self.open(address, ready)

    def open(self, address, ready=True) -> None:
        """Open an address in this tab."""
        if address.startswith("http"):
            address, hash_, fragment = address.partition("#")
            address += f"{'&' if '?' in address else '?'}fixedDpr={self._resolution:g}"
            address += hash_ + fragment
        self.page.goto(address)
        if ready:
            self.wait_for_scene()

    @property
    def foreign_requests(self) -> list[str]:
        """Requests that left this machine."""
        own = ("127.0.0.1", "localhost", "::1")
        return [
            url
            for url in self.requests
            if urlsplit(url).scheme not in ("data", "blob") and urlsplit(url).hostname not in own
        ]

    def wait_for_scene(self) -> None:
        """Wait until the page is connected and draws."""
        self.page.locator(SCENE).first.wait_for(state="visible")
        self.eventually(lambda: self._camera is not None, "the page sends its camera")
        self._next_frames()

    def wait_for_loss(self) -> None:
        """Wait until the page knows that its server is gone."""
        self.eventually(lambda: self._camera is None, "the websocket is closed")

    def wait_for_text(self, words: str | re.Pattern[str]) -> None:
        """Wait until the panel or a notice shows words."""
        self.page.get_by_text(words).first.wait_for(state="visible")

    def wait_for_element(self, selector: str, words: str) -> None:
        """Wait until an element of the page's own script shows words."""
        self.page.locator(selector, has_text=words).first.wait_for(state="visible")

    def shows(self, words: str) -> bool:
        """Whether the panel or a notice shows words now."""
        return self.page.get_by_text(words).first.is_visible()

    def pixels(self) -> np.ndarray:
        """The scene without panel and notices: red, green, blue, shape (height, width, 3)."""
        shot = self.page.screenshot(style=SCENE_ALONE, animations="disabled")
        return np.asarray(Image.open(io.BytesIO(shot)).convert("RGB"), dtype=np.int16)

    def still_pixels(self) -> np.ndarray:
        """The scene once three pictures in a row are the same.

        Between them the server sends a frame, of which a busy page draws one part after another.
        """
        newest = [self.pixels()]

        def settled() -> bool:
            self.page.wait_for_timeout(1000.0 * FRAME_PERIOD)
            self._next_frames()
            newest.append(self.pixels())
            return len(newest) > 2 and all(np.array_equal(newest[-1], p) for p in newest[-3:])

        self.eventually(settled, "the scene stands still")
        return newest[-1]

    def pixels_unlike(self, before: np.ndarray) -> np.ndarray:
        """The scene once it differs from a picture."""
        newest = [before]

        def differs() -> bool:
            newest.append(self.pixels())
            return not np.array_equal(newest[-1], before)

        self.eventually(differs, "the scene changes")
        return newest[-1]

    def wait_for_picture(self, picture) -> None:
        """Wait until the scene is what ``picture()`` is, but for a few pixels.

        A line may be drawn a pixel beside where it was, and another page may still be drawing, too.
        """

        def agrees() -> bool:
            other = np.any(np.abs(self.pixels() - picture()) > CLOSE, axis=-1)
            return bool(np.mean(other) < FEW)

        self.eventually(agrees, "the pictures agree")

    def pixel_of(self, points):
        """Where points of ``map`` are seen: right and down from the page's upper left corner.

        Args:
            points: Shape (..., 3); the answer is an array of shape (..., 2).
        """
        camera = self._camera
        w, *axis = camera["wxyz"]
        axis, ray = np.array(axis), np.asarray(points, dtype=float) - camera["position"]
        # From the world into the camera, which looks along z with y downwards: q* v q.
        across = 2.0 * np.cross(-axis, ray)
        right, down, ahead = np.moveaxis(ray + w * across + np.cross(-axis, across), -1, 0)
        assert np.all(ahead > 0.0), "a point is behind the camera"
        box = self.page.locator(SCENE).first.bounding_box()
        focal = 0.5 * box["height"] / math.tan(0.5 * camera["fov"])
        middle = [box["x"] + 0.5 * box["width"], box["y"] + 0.5 * box["height"]]
        return middle + focal * np.stack([right / ahead, down / ahead], axis=-1)

    def drag(self, begin: tuple[float, float], end: tuple[float, float], steps: int = 8) -> None:
        """Press the mouse at a pixel, move it to another one and let go.

        A page that is drawn slowly learns late what lies under the mouse; hence the rests.
        """
        mouse = self.page.mouse
        mouse.move(*begin)
        self._next_frames()
        mouse.down()
        for k in range(1, steps + 1):
            share = k / steps
            mouse.move(*(b + share * (e - b) for b, e in zip(begin, end, strict=True)))
            self._next_frames()
        mouse.up()
        self._next_frames()

    def enter(self, label: str, value: float, effect) -> None:
        """Write a number into the field beside a slider, until it has its effect.

        A field that is drawn anew in that moment forgets what is written; to ask for the same
        number twice is to ask for it once.

        Args:
            label: Of the slider.
            value: In its unit.
            effect: Whether the number was taken.
        """

        def taken() -> bool:
            field = self.row(label).locator("input[inputmode=decimal]")
            field.fill(f"{value:g}")
            field.press("Enter")
            self._next_frames()
            return effect()

        self.eventually(taken, f"{label} {value:g} is taken")

    def entered(self, label: str) -> float:
        """The number in the field beside a slider."""
        return float(self.row(label).locator("input[inputmode=decimal]").input_value())

    def press(self, words: str) -> None:
        """Press a button of the panel, once: in the focus, by a key.

        The panel grows and shrinks with what it says, and a page that is drawn slowly may move a
        button away between the mouse's down and up, which is then no click. The key finds it.
        """
        button = self.page.get_by_role("button", name=words, exact=True)
        button.click(trial=True)  # waits until the mouse could: it is enabled, nothing covers it
        button.press("Enter")

    def row(self, label: str):
        """The row of the panel with a label."""
        return self.page.locator("label", has_text=label).locator("xpath=../../..")

    def eventually(self, condition, words: str) -> None:
        """Wait for a condition while the page goes on."""
        deadline = time.monotonic() + PATIENCE
        while not condition():
            assert time.monotonic() < deadline, f"not within {PATIENCE:g} s: {words}"
            self.page.wait_for_timeout(200)  # in which playwright hears what the page does

    def _next_frames(self) -> None:
        """Let the page draw what it knows."""
        self.page.evaluate(
            "() => new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))"
        )

    def _note_console(self, message) -> None:
        self.console.append(message.text)
        if message.type == "error":
            self.errors.append(message.text)

    def _note_websocket(self, websocket) -> None:
        self.requests.append(websocket.url)
        websocket.on("framesent", self._note_frame)
        websocket.on("close", self._forget_camera)

    def _forget_camera(self, websocket) -> None:
        self._camera = None

    def _note_frame(self, payload) -> None:
        """The page tells its server each time where its camera is."""
        message = msgspec.msgpack.decode(payload)
        if message["type"] == "ViewerCameraMessage":
            self._camera = message


if __name__ == "__main__":
    _main(*sys.argv[1:])
