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

import numpy as np
import pytest
from seen_page import SeenPage
from served_page import PageProcess, save_flight, served

pytestmark = [pytest.mark.browser, pytest.mark.timeout(900)]


@pytest.fixture
def source(flight):
    """The flight, standing at its begin."""
    from uav_tracking_mpc.view.recorded.logged_flight import LoggedSource

    source = LoggedSource(*flight)
    source.clock.pause()
    return source


def around(pixels, place, radius=6):
    """A square of a picture."""
    column, row = (round(number) for number in place)
    return pixels[row - radius : row + radius, column - radius : column + radius]


def test_it_loads_without_an_error_and_asks_nobody_else(look, source):
    source.clock.play()
    with served(source) as page:
        seen = look(page.address)
        seen.wait_for_text("Airspeed")
        assert seen.errors == []
        assert seen.foreign_requests == []
        assert any(url.startswith("ws://127.0.0.1") for url in seen.requests)


def test_the_scene_moves_with_the_aircraft_and_stands_with_the_clock(look, source):
    begin, end = 2.0, 14.0
    source.clock.seek(begin)
    aircraft = source.flights()[0]
    with served(source) as page:
        seen = look(page.address)
        first = seen.still_pixels()
        for _ in range(3):
            assert np.array_equal(seen.pixels(), first)
        source.clock.seek(end)
        seen.pixels_unlike(first)
        second = seen.still_pixels()
        # It was where the camera says, and came to where the camera says.
        for time in (begin, end):
            place = seen.pixel_of(aircraft.at(time).position)
            assert not np.array_equal(around(first, place), around(second, place))
        source.clock.play()
        seen.pixels_unlike(second)


@pytest.mark.parametrize("direction", ["clockwise", "counter_clockwise"])
def test_the_orbit_that_is_asked_for_is_seen_either_way_round(look, direction):
    """Half of its dashed circle has the aircraft's colour, and the circle inside of it none."""
    from uav_tracking_mpc import load_configuration, simulate
    from uav_tracking_mpc.view.page import COLOURS
    from uav_tracking_mpc.view.recorded.logged_flight import LoggedSource

    overrides = ["mission.duration=2.0", f"nmpc_controller.direction={direction}"]
    configuration = load_configuration("small_uav", overrides)
    source = LoggedSource(simulate(configuration), configuration.controller)
    source.clock.pause()
    wanted = source.flights()[0].sight.wanted
    turn = np.linspace(0.0, 2.0 * np.pi, 120, endpoint=False)
    circle = np.stack([np.cos(turn), np.sin(turn), np.zeros_like(turn)], axis=1)
    with served(source) as page:
        seen = look(page.address)
        pixels = seen.still_pixels()
        shares = []
        for size in (1.0, 0.85):
            points = wanted.centre + size * abs(wanted.radius) * circle
            places = [around(pixels, seen.pixel_of(point), 2) for point in points]
            away = [np.abs(place - COLOURS[0]).max(axis=2).min(initial=255) for place in places]
            shares.append(np.mean(np.array(away) < 60))
        assert shares[0] > 0.3
        assert shares[1] < 0.05


def test_the_replay_stands_at_the_time_of_its_slider(look, source):
    (aircraft,) = source.flights()
    with served(source) as page:
        seen = look(page.address)
        seen.wait_for_text("0:00.0")
        first = seen.still_pixels()

        def stands():  # a field that is just drawn anew forgets what is entered
            seen.enter("time [s]", 12.5)
            return source.clock.time == 12.5

        seen.eventually(stands, "the replay stands where it was sent")
        seen.wait_for_text("0:12.5")
        second = seen.still_pixels()
        place = seen.pixel_of(aircraft.at(12.5).position)
        assert not np.array_equal(around(first, place), around(second, place))
        seen.enter("time [s]", 0.0)
        seen.wait_for_text("0:00.0")
        assert np.array_equal(seen.still_pixels(), first)


def test_two_pages_at_once_and_one_opened_again(look, source):
    with served(source) as page:
        one, two = look(page.address), look(page.address)
        first = one.still_pixels()
        assert np.array_equal(two.still_pixels(), first)
        one.page.close()
        source.clock.seek(3.0)
        two.pixels_unlike(first)
        again = look(page.address)
        assert np.array_equal(again.still_pixels(), two.still_pixels())
        assert two.errors == again.errors == []


def test_the_page_opens_again_when_its_server_was_started_again(look, flight, tmp_path):
    saved = save_flight(*flight, tmp_path / "flight.pickle")
    with PageProcess(saved) as process:
        seen = look(process.address)
        seen.wait_for_text("Airspeed")
        process.kill()
        seen.wait_for_loss()
        with PageProcess(saved, process.port) as again:  # of a new token
            seen.page.goto(again.address)
            seen.wait_for_scene()
            seen.wait_for_text("Airspeed")
            moving = seen.pixels()
            seen.pixels_unlike(moving)


def test_with_a_token_the_page_opens_and_without_it_says_why(look, source):
    with served(source) as page:
        refused = look(page.address.partition("?")[0], ready=False)
        refused.wait_for_text("asks for its token")
        seen = look(page.address)
        seen.wait_for_text("Airspeed")
        assert seen.errors == []
        again = look(page.address.partition("?")[0])  # the browser keeps it as a cookie
        again.wait_for_text("Airspeed")
        assert again.page.evaluate("document.cookie") == ""


def test_another_site_reaches_no_websocket_and_shows_no_page(context, source):
    with served(source) as page, _site(b"<!doctype html><title>another site</title>") as site:
        tab = context.new_page()
        tab.goto(site)
        script = """address => new Promise(done => {
            const socket = new WebSocket(address, "viser-v" + "1.1.1");
            socket.onopen = () => done("open");
            socket.onerror = () => done("refused");
        })"""
        assert tab.evaluate(script, page.address.replace("http:", "ws:")) == "refused"
        tab.set_content(f'<iframe src="{page.address}"></iframe>')
        frame = tab.frame_locator("iframe")
        tab.wait_for_timeout(2000)
        assert frame.locator("canvas").count() == 0


def test_an_address_cannot_point_the_page_at_another_server(look, source):
    """What another server sends would run as this page, and could steer."""
    with served(source) as page, socket.create_server(("127.0.0.1", 0)) as other:
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


def test_the_browser_that_is_opened_is_led_to_the_page(context, source, monkeypatch, tmp_path):
    """By a file: in the arguments of its process everybody could read the token."""
    from uav_tracking_mpc.view.serving import browser

    started = []
    monkeypatch.setattr(browser.subprocess, "Popen", lambda words, **_: started.append(words))
    monkeypatch.setenv("HOME", str(tmp_path))
    with served(source) as page, browser.open_browser(page.address):
        (words,) = started
        assert not any("token" in word for word in words)
        seen = SeenPage(context.new_page(), words[-1])
        seen.wait_for_text("Airspeed")
        assert seen.errors == []
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
