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

"""The live page in a real browser."""

import contextlib
import http.server
import socket
import threading
from dataclasses import replace

import numpy as np
import pytest
from seen_page import PageProcess, SeenPage, save_flight, served
from watched_flight_stand_in import StandInFlight, StandInSource

pytestmark = [pytest.mark.browser, pytest.mark.timeout(900)]


def logged(flight):
    """A flight that stands at its begin."""
    from uav_tracking_mpc.view.recorded_scene import LoggedSource

    source = LoggedSource(*flight)
    source.clock.pause()
    return source


@pytest.fixture(scope="module")
def source(flight):
    """The flight of the page that tests share: to open one costs more than most of them."""
    return logged(flight)


@pytest.fixture
def seen(opened, source):
    """The page that tests share, at the begin of its flight."""
    source.clock.pause()
    source.clock.seek(source.clock.begin)
    return opened


def around(pixels, place, radius=6):
    """A square of a picture."""
    column, row = (round(number) for number in place)
    return pixels[row - radius : row + radius, column - radius : column + radius]


def test_it_loads_without_an_error_and_asks_nobody_else(seen, source):
    source.clock.play()
    seen.wait_for_text("Airspeed")
    assert seen.errors == []
    assert seen.foreign_requests == []
    assert any(url.startswith("ws://127.0.0.1") for url in seen.requests)


def test_the_scene_moves_with_the_aircraft_and_stands_with_the_clock(seen, source):
    begin, end = 2.0, 14.0
    source.clock.seek(begin)
    seen.wait_for_text("0:02.0")
    aircraft = source.flights()[0]
    first = seen.still_pixels()
    for _ in range(3):
        assert np.array_equal(seen.pixels(), first)
    source.clock.seek(end)
    seen.wait_for_text("0:14.0")
    seen.pixels_unlike(first)
    second = seen.still_pixels()
    # It was where the camera says, and came to where the camera says.
    for time in (begin, end):
        place = seen.pixel_of(aircraft.at(time).position)
        assert not np.array_equal(around(first, place), around(second, place))
    source.clock.play()
    seen.pixels_unlike(second)


def test_the_orbit_that_is_asked_for_is_seen_either_way_round(look):
    """Half of its dashed circle has the aircraft's colour, and the circle inside of it none."""
    from uav_tracking_mpc import load_configuration, simulate
    from uav_tracking_mpc.view.page import COLOURS

    sights = []
    for direction in ("clockwise", "counter_clockwise"):
        overrides = ["mission.duration=2.0", f"nmpc_controller.direction={direction}"]
        configuration = load_configuration("small_uav", overrides)
        source = logged((simulate(configuration), configuration.controller))
        sights.append(source.flights()[0].sight)
    one, other = sights
    assert one.wanted.radius * other.wanted.radius < 0.0
    turn = np.linspace(0.0, 2.0 * np.pi, 120, endpoint=False)
    circle = np.stack([np.cos(turn), np.sin(turn), np.zeros_like(turn)], axis=1)
    shown = StandInFlight()
    shown.seen = [replace(one, wanted=None)]
    with served(StandInSource(shown)) as page:
        seen = look(page.address, resolution=0.5)
        pixels = seen.still_pixels()
        for sight in sights:
            shown.seen.append(sight)
            seen.pixels_unlike(pixels)
            pixels = seen.still_pixels()
            shares = []
            for size in (1.0, 0.85):
                points = sight.wanted.centre + size * abs(sight.wanted.radius) * circle
                places = [around(pixels, seen.pixel_of(point), 2) for point in points]
                away = [np.abs(place - COLOURS[0]).max(axis=2).min(initial=255) for place in places]
                shares.append(np.mean(np.array(away) < 60))
            assert shares[0] > 0.3
            assert shares[1] < 0.05


def test_the_replay_stands_at_the_time_of_its_slider(seen, source):
    (aircraft,) = source.flights()
    seen.wait_for_text("0:00.0")
    first = seen.still_pixels()
    seen.enter("time [s]", 12.5, lambda: source.clock.time == 12.5)
    seen.wait_for_text("0:12.5")
    second = seen.still_pixels()
    place = seen.pixel_of(aircraft.at(12.5).position)
    assert not np.array_equal(around(first, place), around(second, place))
    seen.enter("time [s]", 0.0, lambda: source.clock.time == 0.0)
    seen.wait_for_text("0:00.0")
    seen.wait_for_picture(lambda: first)


def test_two_pages_at_once_and_one_opened_again(look, page, seen, source):
    one = look(page.address)
    seen.wait_for_text("0:00.0")
    first = one.still_pixels()
    seen.wait_for_picture(one.pixels)
    one.page.close()
    source.clock.seek(3.0)
    seen.pixels_unlike(first)
    again = look(page.address)
    seen.wait_for_text("0:03.0")
    again.wait_for_picture(seen.pixels)
    assert not np.array_equal(seen.pixels(), first)
    assert seen.errors == again.errors == []


def test_the_page_opens_again_when_its_server_was_started_again(look, flight, tmp_path):
    saved = save_flight(*flight, tmp_path / "flight.pickle")
    with PageProcess(saved) as process:
        seen = look(process.address)
        seen.wait_for_text("Airspeed")
        process.kill()
        seen.wait_for_loss()
        with PageProcess(saved, process.port) as again:  # of a new token
            seen.open(again.address)
            seen.wait_for_text("Airspeed")
            moving = seen.pixels()
            seen.pixels_unlike(moving)


def test_with_a_token_the_page_opens_and_without_it_says_why(chromium, look, page, seen):
    without = page.address.partition("?")[0]
    stranger = chromium.new_context()
    refused = SeenPage(stranger.new_page(), without, ready=False)
    refused.wait_for_text("asks for its token")
    stranger.close()
    assert seen.errors == []
    again = look(without)  # the browser keeps it as a cookie
    again.wait_for_text("Airspeed")
    assert again.page.evaluate("document.cookie") == ""


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
        port = other.getsockname()[1]
        seen = look(f"{page.address}&websocket=ws://127.0.0.1:{port}", ready=False)
        tries = f"Connecting to: ws://127.0.0.1:{port}"
        seen.eventually(
            lambda: any(tries in words for words in seen.console), "the page tries to connect"
        )
        look(page.address)  # by then a connection would have come; without the policy it does
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
        seen = SeenPage(stranger.new_page(), words[-1])
        seen.wait_for_text("Airspeed")
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
