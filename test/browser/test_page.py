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

"""The live page in a real browser, of a bag's replay."""

import contextlib
import http.server
import socket
import threading

import numpy as np
import pytest
from recorded_bag import write_bag
from seen_page import PageProcess, SeenPage, save_flight

pytestmark = pytest.mark.browser
BEGIN, END = 2.0, 14.0  # s, of which there are pictures
LINE = """canvas => {
    const data = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data;
    let blue = 0;
    for (let k = 0; k < data.length; k += 4) blue += data[k + 2] > data[k] + 60;
    return blue;
}"""  # pixels in the colour of the lines


@pytest.fixture(scope="module")
def source(tmp_path_factory):
    """The record of the page that tests share: to open one costs more than most of them."""
    from uav_tracking_mpc.view.recorded_source import RecordedSource

    path = tmp_path_factory.mktemp("bag") / "flight.mcap"
    write_bag(path, 20.0, state_rate=20, command_rate=10)
    return RecordedSource(path)


@pytest.fixture
def seen(opened, source):
    """That page, which stands at the begin of its flight."""
    source.clock.pause()
    source.clock.seek(source.clock.begin)
    return opened


def around(pixels, place, radius=6):
    """A square of a picture."""
    column, row = (round(number) for number in place)
    return pixels[row - radius : row + radius, column - radius : column + radius]


def test_it_loads_without_an_error_and_asks_nobody_else(seen):
    seen.wait_for_text("Airspeed")
    assert seen.errors == []
    assert seen.foreign_requests == []
    assert any(url.startswith("ws://127.0.0.1") for url in seen.requests)


def test_the_scene_stands_at_the_time_of_the_slider_and_moves_with_the_clock(seen, source):
    (aircraft,) = source.flights()
    pictures = []
    for time in (END, BEGIN, END):  # jumps, after which a track is drawn anew
        seen.enter("time [s]", time, lambda time=time: source.clock.time == time)
        seen.wait_for_text(f"0:{time:04.1f}")
        pictures.append(seen.still_pixels())
    first, second, again = pictures
    # It was where the camera says, and came to where the camera says.
    for sight in map(aircraft.at, (BEGIN, END)):
        centre = sight.wanted.centre * [1.0, 1.0, 0.0]  # with which the scene goes
        place = seen.pixel_of(sight.position - centre)
        assert not np.array_equal(around(first, place), around(second, place))
    seen.wait_for_picture(lambda: first)
    source.clock.play()
    seen.pixels_unlike(again)


def test_one_page_goes_back_and_comes_again_while_the_other_stays(look, page, seen, source):
    """The other one is opened without the token: the browser keeps it as a cookie."""
    source.clock.seek(END)
    other = look(page.address.partition("?")[0])
    assert other.page.evaluate("document.cookie") == ""
    for each in (seen, other):
        each.wait_for_element("#flight-time", "0:14.0")
    assert other.still_pixels().std() > 1.0  # its own view of the scene
    if seen.page.locator("#flight-strip.folded").count():
        seen.page.get_by_title("Fold or unfold").click()
    canvas = seen.page.locator("#flight-strip canvas")
    seen.eventually(lambda: int(canvas.get_attribute("data-rows") or 0) > 15, "the strip has rows")
    seen.eventually(lambda: canvas.evaluate(LINE) > 200, "its lines are drawn")
    now = seen.still_pixels()  # in what the strip leaves
    canvas.focus()
    for _ in range(2):
        canvas.press("PageDown")  # 10 s back each, no farther than the begin
    seen.wait_for_element("#flight-time", "0:00.0")
    seen.wait_for_element("#flight-words", "The picture is of another time")
    seen.wait_for_element("#flight-card", "Airspeed")
    seen.page.get_by_text("limits").first.wait_for(state="hidden")  # the readings of now
    seen.eventually(lambda: seen.page.title().startswith("past"), "the title says so")
    past = seen.pixels_unlike(now)
    assert other.page.locator("#flight-time").text_content() == "0:14.0"
    seen.page.get_by_role("button", name="replay", exact=True).click()
    seen.wait_for_element("#flight-time", "0:14.0")
    assert seen.page.locator("body.flight-past").count() == 0
    seen.pixels_unlike(past)
    assert seen.errors == other.errors == []


def test_a_server_that_dies_is_announced_and_its_successor_opens_by_its_own_address(
    look, flight, tmp_path
):
    saved = save_flight(*flight, tmp_path / "flight.pickle")
    with PageProcess(saved) as process:
        seen = look(process.address)
        seen.eventually(lambda: seen.page.title().startswith("optimal"), "the title says the mode")
        process.kill()
        seen.wait_for_loss()
        seen.wait_for_element("#flight-banner", "Connection lost: the picture is")
        seen.wait_for_element("#flight-words", "no connection")  # and not that time stands
        with PageProcess(saved, process.port) as again:  # of a new token
            seen.wait_for_element("#flight-banner", "Open the address that it prints")
            seen.open(again.address)
            seen.wait_for_text("Airspeed")


def test_without_the_token_the_page_says_why(chromium, page):
    stranger = chromium.new_context()
    refused = SeenPage(stranger.new_page(), page.address.partition("?")[0], ready=False)
    refused.wait_for_text("asks for its token")
    stranger.close()


def test_another_site_reaches_no_websocket_and_shows_no_page(context, page):
    with _site(b"<!doctype html><title>another site</title>") as site:
        tab = context.new_page()
        tab.goto(site)
        script = """address => new Promise(done => {
            const socket = new WebSocket(address, "viser-v" + "1.1.1");
            socket.onopen = () => done("open");
            socket.onerror = () => done("refused");
        })"""
        assert tab.evaluate(script, page.address.replace("http:", "ws:")) == "refused"
        tab.set_content(f'<iframe src="{page.address}"></iframe>')
        frame = tab.frames[1]  # loaded by now, with what was refused or with the page
        assert frame.url.startswith("chrome-error:")
        assert frame.locator("canvas").count() == 0
        tab.close()


def test_an_address_cannot_point_the_page_at_another_server(look, page):
    """What another server sends would run as this page, and could steer."""
    with socket.create_server(("127.0.0.1", 0)) as other:
        elsewhere = f"ws://127.0.0.1:{other.getsockname()[1]}"
        seen = look(f"{page.address}&websocket={elsewhere}", ready=False)
        tries = f"Connecting to: {elsewhere}"
        seen.eventually(
            lambda: any(tries in words for words in seen.console), "the page tries to connect"
        )
        # By then a connection would have come; without the policy it does.
        seen.eventually(lambda: "· uav ·" in seen.page.title(), "its own server has answered")
        other.setblocking(False)
        with pytest.raises(BlockingIOError):
            other.accept()


def test_the_browser_that_is_opened_is_led_to_the_page(context, page, monkeypatch, tmp_path):
    """By a file: in the arguments of its process everybody could read the token."""
    from uav_tracking_mpc.view.serving import browser

    started = []
    monkeypatch.setattr(browser.subprocess, "Popen", lambda words, **_: started.append(words))
    monkeypatch.setenv("HOME", str(tmp_path))
    with browser.open_browser(page.address):
        (words,) = started
        assert not any("token" in word for word in words)
        stranger = context.browser.new_context()  # who has no cookie yet
        seen = SeenPage(stranger.new_page(), words[-1], ready=False)
        seen.page.wait_for_url(page.address)
        seen.eventually(lambda: "uav" in seen.page.title(), "the page of the flight is there")
        assert seen.errors == []
        stranger.close()
    assert list(tmp_path.iterdir()) == []


@contextlib.contextmanager
def _site(content):
    class Site(http.server.BaseHTTPRequestHandler):
        def do_GET(self):
            self.send_response(200)
            self.send_header("Content-Type", "text/html")
            self.end_headers()
            self.wfile.write(content)

        def log_message(self, *_):
            pass

    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), Site) as server:
        thread = threading.Thread(target=server.serve_forever, daemon=True)
        thread.start()
        yield f"http://127.0.0.1:{server.server_address[1]}/"
        server.shutdown()
