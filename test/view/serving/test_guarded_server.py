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

"""The server answers to whom it should, at an address that says where."""

import contextlib
import gc
import gzip
import logging
import re
import socket
import warnings
from concurrent.futures import ThreadPoolExecutor
from types import SimpleNamespace

import msgspec
import pytest
import viser
from processes import scripted, wait_for
from websockets.exceptions import ConnectionClosedError, InvalidStatus
from websockets.sync.client import connect

from uav_tracking_mpc.view.serving import guarded_server
from uav_tracking_mpc.view.serving.guarded_server import (
    Access,
    GuardedServer,
    address_of,
    listen,
    new_token,
)

HERE = "127.0.0.1:8080"


WITH = "/?token=secret"
OWN = [HERE, "localhost:8080", "LOCALHOST", "[::1]:8080", "127.0.0.2", "robot:8080",
       "192.168.1.7:8080", "[fd00::7]:8080"]  # fmt: skip
OTHERS = ["rebound.example:8080", "", "127.0.0.1.example", "a b", "[::1"]
SITES = ["http://site.example", "http://127.0.0.1:3000", "http://localhost:8080", "null", "",
         "file://"]  # fmt: skip
WRONG = ["/?token=wrong", "/?token=", "/?token=secre%C3%A9", "/?token=\udcff"]


@pytest.mark.parametrize(
    ("words", "path", "hosts", "origins"),
    [
        *(("", WITH, [host], []) for host in OWN),
        *(("", WITH, [host], [f"http://{host}"]) for host in OWN),
        *(("token", "/", [host], []) for host in OWN),
        *(("token", path, [HERE], []) for path in WRONG),
        *(("host name", WITH, hosts, []) for hosts in ([], [HERE, HERE], *([x] for x in OTHERS))),
        *(("other sites", WITH, [HERE], [origin]) for origin in SITES),
        ("other sites", WITH, [HERE], [f"http://{HERE}"] * 2),
    ],
)
def test_who_may_open_a_page(words, path, hosts, origins):
    refusal = Access("secret", names=["Robot"]).refusal(path, hosts, origins, [])
    assert words in refusal and bool(words) == bool(refusal)


def test_the_cookie_stands_for_the_token():
    access = Access("secret")
    name, _, rest = access.cookie.partition("=")
    own = f"{name}={rest.partition(';')[0]}"
    for other in ("theme=dark", 'prefs={"a":1}', "no cookie", "user=Müller"):  # of other programs
        for cookies in (f"{other}; {own}", f"{own}; {other}"):
            assert access.refusal("/", [HERE], [], [cookies]) == ""
    for wrong in (f"{name}=wrong", "uav_tracking=secret"):
        assert "token" in access.refusal("/", [HERE], [], [wrong])
    assert "HttpOnly" in rest and "SameSite=Strict" in rest
    assert name != Access("other").cookie.partition("=")[0]


def test_every_token_is_new():
    assert new_token() != new_token()
    assert len(new_token()) >= 32


pytest.importorskip("viser")


PATIENCE = 60.0  # s: a limit for broken servers, not a measure of good ones
PROTOCOL = f"viser-v{viser.__version__}"


@contextlib.contextmanager
def served(host=None):
    server = GuardedServer(host, 0, label="test")
    try:
        yield server
    finally:
        server.stop()


@pytest.fixture(scope="module")
def open_server():
    with served() as server:
        yield server


def token_of(server):
    return server.address.partition("?token=")[2]


def cookie_of(server):
    """As the page itself sets it."""
    return re.search(r"Set-Cookie: ([^;]*)", get(server)[1]).group(1)


def send(server, raw):
    """Everything that is answered until the server closes."""
    with socket.create_connection(("127.0.0.1", server.get_port()), timeout=PATIENCE) as client:
        client.sendall(raw)
        answer = b""
        with contextlib.suppress(ConnectionResetError):
            while piece := client.recv(65536):
                answer += piece
    return answer


def get(server, path=None, host=None, **headers):
    """Status, head and body of a request."""
    host = f"127.0.0.1:{server.get_port()}" if host is None else host
    path = f"/?token={token_of(server)}" if path is None else path
    lines = [f"GET {path} HTTP/1.1", f"Host: {host}"]
    lines += [f"{name}: {value}" for name, value in headers.items()]
    head, _, body = send(server, "\r\n".join([*lines, "", ""]).encode()).partition(b"\r\n\r\n")
    return int(head.split()[1]), head.decode(), body


def open_websocket(server, protocol=PROTOCOL, **options):
    port = server.get_port()
    options.setdefault("additional_headers", {"Cookie": cookie_of(server)})
    options.setdefault("origin", f"http://127.0.0.1:{port}")
    return connect(
        f"ws://127.0.0.1:{port}",
        subprotocols=[protocol],
        open_timeout=PATIENCE,
        proxy=None,
        **options,
    )


def test_the_page_is_served_on_loopback_alone(open_server):
    token = token_of(open_server)
    assert open_server.address == f"http://127.0.0.1:{open_server.get_port()}/?token={token}"
    assert len(token) >= 32
    status, head, body = get(open_server)
    assert status == 200
    assert b"<title>uav_tracking</title>" in body
    assert "frame-ancestors 'none'" in head


@pytest.mark.parametrize(
    ("headers", "words"),
    [
        ({"host": "rebound.example"}, b"host name"),
        ({"Origin": "http://site.example"}, b"other sites"),
        ({"Origin": "null"}, b"other sites"),
    ],
)
def test_foreign_hosts_and_origins_get_words(open_server, headers, words):
    status, _, body = get(open_server, **headers)
    assert status == 403
    assert words in body
    assert body.count(b"\n") == 1


def is_refused(server, **options):
    with pytest.raises(InvalidStatus) as refused:
        open_websocket(server, **options)
    return refused.value.response.status_code == 403


def test_a_websocket_opens_from_the_page_and_from_no_other(open_server):
    with open_websocket(open_server) as websocket:
        assert websocket.recv(timeout=PATIENCE)
    for origin in ("http://site.example", "http://127.0.0.1:1", "null"):
        assert is_refused(open_server, origin=origin)


def test_without_the_token_nothing_opens(open_server):
    for path in ("/", "/?token=wrong", "/index.html", "/no/such/file"):
        status, head, body = get(open_server, path)
        assert (status, body.count(b"\n")) == (403, 1)
        assert b"token" in body
        assert token_of(open_server) not in head + body.decode()
    for cookie in ("", "uav_tracking=1", "uav_tracking_00000000=" + token_of(open_server)):
        assert is_refused(open_server, additional_headers={"Cookie": cookie})


@pytest.fixture
def answering():
    with served() as server:
        server.answers["/flight/now"] = lambda query: f'{{"asked": "{query.get("page", [""])[0]}"}}'
        yield server


def test_the_script_is_answered_behind_the_same_check(answering):
    path = f"/flight/now?page=3&token={token_of(answering)}"
    status, head, body = get(answering, path)
    assert (status, body) == (200, b'{"asked": "3"}')
    assert "Content-Type: application/json" in head and "Cache-Control: no-store" in head
    assert get(answering, "/flight/now", Cookie=cookie_of(answering))[0] == 200
    for wrong in ("/flight/now", "/flight/now?token=wrong"):
        status, _, body = get(answering, wrong)
        assert status == 403 and b"token" in body
    assert get(answering, path, Origin="http://site.example")[0] == 403
    assert get(answering, path, host="rebound.example")[0] == 403


def test_an_answer_that_fails_is_one_line_of_the_log_and_the_server_goes_on(answering, caplog):
    answering.answers["/flight/now"] = lambda query: 1 / 0
    for _ in range(3):
        assert get(answering, f"/flight/now?token={token_of(answering)}")[0] == 500
    assert caplog.text.count("was not answered") == 1
    assert get(answering)[0] == 200


def test_many_ask_at_once_and_all_are_answered(answering):
    path = f"/flight/now?token={token_of(answering)}"
    with ThreadPoolExecutor(20) as executor:
        found = list(executor.map(lambda k: get(answering, f"{path}&page={k}"), range(200)))
    assert [body for _, _, body in found] == [b'{"asked": "%d"}' % k for k in range(200)]


def test_the_page_holds_the_script_compressed_or_not(open_server):
    _, head, plain = get(open_server)
    zipped = get(open_server, **{"Accept-Encoding": "gzip"})[2]
    assert gzip.decompress(zipped) == plain
    assert f"Content-Length: {len(plain)}" in head
    assert plain.count(b"__FLIGHT_RECORD__=null") == 1


def test_the_token_becomes_a_cookie_and_the_cookie_opens_the_websocket(open_server):
    assert re.search("Set-Cookie: .*HttpOnly; SameSite=Strict", get(open_server)[1])
    cookie = cookie_of(open_server)
    assert get(open_server, "/", Cookie=cookie)[0] == 200
    with open_websocket(open_server, additional_headers={"Cookie": cookie}) as websocket:
        assert websocket.recv(timeout=PATIENCE)


def test_a_head_that_does_not_end_is_cut_off(open_server):
    address = f"Host: 127.0.0.1:{open_server.get_port()}\r\n".encode()
    long_line = send(open_server, b"GET / HTTP/1.1\r\n" + address + b"X: " + b"x" * 1_000_000)
    many_lines = send(open_server, b"GET / HTTP/1.1\r\n" + address + b"X: x\r\n" * 100_000)
    for answer in (long_line, many_lines, send(open_server, b"\x16\x03\x01\x00\xff\r\n\r\n")):
        assert b"<title>" not in answer
    assert get(open_server)[0] == 200


def test_slow_clients_neither_keep_others_waiting_nor_stay(monkeypatch):
    monkeypatch.setattr(guarded_server, "HEAD_TIME", 2.0)
    with contextlib.ExitStack() as stack:
        server = stack.enter_context(served())
        slow = [
            stack.enter_context(
                socket.create_connection(("127.0.0.1", server.get_port()), timeout=PATIENCE)
            )
            for _ in range(50)
        ]
        for client in slow:
            client.sendall(b"GET / HTTP/1.1\r\nHost: 127")
        assert get(server)[0] == 200
        for client in slow:
            with contextlib.suppress(ConnectionResetError):
                while client.recv(65536):  # TimeoutError where it stays open
                    pass


def test_the_page_is_shared_with_nobody(open_server, caplog):
    """A client may ask for it whether or not the page has a button for it."""
    with open_websocket(open_server) as websocket:
        websocket.send(b"\x81\xa4type\xafShareUrlRequest")  # msgpack of {"type": "ShareUrlRequest"}
        assert wait_for(lambda: "refused to share it" in caplog.text, PATIENCE)
    assert open_server.request_share_url() is None


def test_a_reason_is_logged_once(caplog):
    with served() as server, caplog.at_level(logging.INFO):
        for _ in range(3):
            get(server, Origin="http://site.example")
        get(server)
    said = [record.getMessage() for record in caplog.records]
    assert said == ["page: refused a request of 127.0.0.1: other sites may not use this page"]


def pack(**message):
    return msgspec.msgpack.encode(message)


def test_junk_is_one_line_of_a_kind_and_the_page_goes_on(caplog, capfd):
    """Text, bytes that are no message, one of no kind, and one that viser cannot do."""
    with served() as server, caplog.at_level(logging.INFO):
        slider = server.gui.add_slider("wind", 0.0, 9.0, 1.0, 2.0)
        uuid = slider._impl.uuid
        beside = pack(type="GuiUpdateMessage", uuid=uuid, updates={"no_such": 1})
        junk = ["text", b"\xc1\xff", pack(type="NoSuchMessage"), pack(no="type"), b"", beside]
        with open_websocket(server) as websocket:
            for _ in range(20):
                for message in junk:
                    websocket.send(message)
            good = pack(type="GuiUpdateMessage", uuid=uuid, updates={"value": 5.0})
            websocket.send(good)
            assert wait_for(lambda: slider.value == 5.0, PATIENCE)
        gc.collect()  # failed tasks speak when they are collected
        assert wait_for(lambda: len(caplog.records) >= 2, PATIENCE)
    assert sorted(record.getMessage() for record in caplog.records) == [
        "page: a message failed: AssertionError()",
        "page: refused a request of 127.0.0.1: its message is none that a page sends",
    ]
    assert capfd.readouterr().err == ""


CAMERA = {
    "wxyz": (1.0, 0.0, 0.0, 0.0),
    "position": (0.0, -9.0, 3.0),
    "look_at": (0.0, 0.0, 0.0),
    "up_direction": (0.0, 0.0, 1.0),
    "fov": 0.9,
    "near": 0.1,
    "far": 1e4,
    "image_height": 600,
    "image_width": 900,
}  # with which a page begins


def test_a_page_that_is_closed_while_it_is_drawn_for_is_no_warning():
    with warnings.catch_warnings(record=True) as caught, served() as server:
        with open_websocket(server) as websocket:
            websocket.send(pack(type="ViewerCameraMessage", **CAMERA))
            assert wait_for(server.get_clients, PATIENCE)
            (client,) = server.get_clients().values()
            frame = client.scene.add_frame("/world")
        assert wait_for(lambda: not server.get_clients(), PATIENCE)
        frame.position = (1.0, 2.0, 3.0)
    assert [str(each.message) for each in caught] == []


def test_a_message_larger_than_any_of_a_page_closes_its_websocket(open_server, caplog):
    with open_websocket(open_server, max_size=None) as websocket:
        with contextlib.suppress(ConnectionClosedError):
            websocket.send(b"x" * 20_000_000)
        assert wait_for(lambda: websocket.close_code == 1009, PATIENCE)  # too big
    assert caplog.text == ""
    assert get(open_server)[0] == 200


def test_a_page_of_another_viser_is_told_to_load_again(open_server):
    with pytest.raises(InvalidStatus) as refused:
        open_websocket(open_server, protocol="viser-v0.0.1")
    assert b"load it again" in refused.value.response.body


def test_a_viser_that_serves_in_another_way_is_not_used(monkeypatch):
    """As a later one may: here it keeps a ``serve`` of its own, which nothing stands in for."""
    from viser.infra import _infra

    library = _infra.websockets
    kept = SimpleNamespace(
        asyncio=SimpleNamespace(server=SimpleNamespace(serve=library.asyncio.server.serve)),
        datastructures=library.datastructures,
        exceptions=library.exceptions,
    )
    monkeypatch.setattr(_infra, "websockets", kept)
    with pytest.raises(RuntimeError, match="nothing would check who opens the page"):
        GuardedServer(None, 0)


def test_nothing_is_printed():
    program = (
        "from uav_tracking_mpc.view.serving.guarded_server import GuardedServer\n"
        "GuardedServer(None, 0).stop()\n"
    )
    assert scripted(program) == (0, "", "")


def test_without_a_port_the_next_free_one_is_taken(monkeypatch):
    with listen(port=0) as first:
        taken = first.getsockname()[1]
        monkeypatch.setattr(guarded_server, "PORT", taken)
        with listen() as second:
            assert taken < second.getsockname()[1] < taken + guarded_server.TRIES
        monkeypatch.setattr(guarded_server, "TRIES", 1)
        with pytest.raises(OSError, match="choose a --port"):
            listen()


def test_addresses_of_others_are_told():
    with pytest.raises(OSError, match=r"cannot listen at 192\.0\.2\.1"):
        listen("192.0.2.1", 0)
    with pytest.raises(OSError, match=r"'no\.such\.host\.invalid' is neither"):
        listen("no.such.host.invalid", 0)


@pytest.mark.parametrize("host", ["127.0.0.1", "localhost"])
def test_the_address_reaches_it(host):
    with listen(host, 0) as listener:
        name, _, port = address_of(listener, host).rpartition(":")
        assert name == f"http://{host}"
        socket.create_connection((listener.getsockname()[0], int(port))).close()


def test_for_every_address_one_is_told():
    with listen("0.0.0.0", 0) as listener:
        name, _, port = address_of(listener, "0.0.0.0").removeprefix("http://").rpartition(":")
        assert name != "0.0.0.0"
        socket.create_connection((name, int(port))).close()


@pytest.mark.skipif(not socket.has_ipv6, reason="no IPv6 here")
def test_an_address_of_ipv6_stands_in_brackets():
    try:
        listener = listen("::1", 0)
    except OSError as error:
        pytest.skip(str(error))
    with listener:
        assert address_of(listener, "::1").startswith("http://[::1]:")
