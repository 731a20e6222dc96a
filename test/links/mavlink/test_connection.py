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

"""The wire: addresses, signing, losses, and frames that are none."""

import contextlib
import random
import socket
import sys
import time
from concurrent.futures import ThreadPoolExecutor

import pytest
from processes import PATIENCE

from uav_tracking_mpc.links import LinkError, LinkRefusedError
from uav_tracking_mpc.links.mavlink import connection
from uav_tracking_mpc.links.mavlink.connection import KEY_LENGTH, Connection
from uav_tracking_mpc.links.mavlink.dialect import mavlink, name_of
from uav_tracking_mpc.studies.faults.link_campaign import changed

FRAMES = 50_000  # mutated ones


def heartbeat(system_status=mavlink.MAV_STATE_ACTIVE):
    return mavlink.MAVLink_heartbeat_message(1, 3, 128, 15, system_status, 3)


@pytest.fixture
def ports():
    """Ports of this machine that nobody uses."""
    found = []
    for kind in (socket.SOCK_DGRAM, socket.SOCK_STREAM):
        with socket.socket(socket.AF_INET, kind) as probe:
            probe.bind(("127.0.0.1", 0))
            found.append(probe.getsockname()[1])
    return found


@pytest.fixture
def pair(ports):
    ours = Connection(f"udpin:127.0.0.1:{ports[0]}")
    theirs = Connection(f"udpout:127.0.0.1:{ports[0]}", component=1)
    theirs.speak_as(3)
    yield ours, theirs
    ours.close()
    theirs.close()


def received(connection, count=1, timeout=60.0):
    """At least so many messages, unless they do not come."""
    messages, end = [], time.monotonic() + timeout
    while len(messages) < count and time.monotonic() < end:
        messages += connection.receive(0.05)
    return messages


def test_a_peer_that_came_again_from_another_port_is_answered_there_alone(pair, ports, monkeypatch):
    ours, first = pair
    first.send(heartbeat())
    assert received(ours)
    monkeypatch.setattr(connection.time, "monotonic", lambda now=time.monotonic: now() + 60.0)
    ours.send(heartbeat())
    assert received(first)  # nobody else has spoken
    again = Connection(f"udpout:127.0.0.1:{ports[0]}", component=1)
    again.speak_as(3)
    again.send(heartbeat())
    assert received(ours)
    ours.send(heartbeat())
    assert received(again)
    assert not first.receive(0.0)
    again.close()


def test_messages_go_both_ways(pair):
    ours, theirs = pair
    ours.speak_as(3)
    for sender, receiver, component in ((theirs, ours, 1), (ours, theirs, 191)):
        sender.send(heartbeat())
        (message,) = received(receiver)
        heard = message.get_type(), message.get_srcSystem(), message.get_srcComponent()
        assert heard == ("HEARTBEAT", 3, component)


def test_a_stream_that_ends_is_told_and_can_be_opened_anew(ports):
    address = f"127.0.0.1:{ports[1]}"
    server, client = Connection(f"tcpin:{address}"), Connection(f"tcp:{address}")
    for _ in range(2):
        server.open()
        client.open()
        client.send(heartbeat())
        assert len(received(server)) == 1
        server.close()
        with pytest.raises(LinkError, match="the other end closed it"):
            received(client)
    client.close()


def test_a_server_takes_the_next_client(ports):
    server = Connection(f"tcpin:127.0.0.1:{ports[1]}")
    for _ in range(2):
        client = Connection(f"tcp:127.0.0.1:{ports[1]}")
        client.send(heartbeat())
        assert len(received(server)) == 1
        server.send(heartbeat())
        assert len(received(client)) == 1
        client.close()
        assert received(server, timeout=0.1) == []
    server.close()


def test_reaching_a_peer_that_does_not_answer_has_a_deadline(monkeypatch):
    monkeypatch.setattr(connection, "OPEN_LIMIT", 0.2)
    with contextlib.ExitStack() as opened:
        full = opened.enter_context(socket.create_server(("127.0.0.1", 0), backlog=0))
        for _ in range(3):  # more than wait to be accepted: the next is not answered
            waiting = opened.enter_context(socket.socket())
            waiting.setblocking(False)
            waiting.connect_ex(full.getsockname())
        with ThreadPoolExecutor(1) as pool:
            reaching = pool.submit(Connection, f"tcp:127.0.0.1:{full.getsockname()[1]}")
            with pytest.raises(LinkError, match="timed out"):
                reaching.result(PATIENCE)


def test_whoever_prints_while_a_wire_is_opened_is_read(ports, monkeypatch):
    found, open_wire = [], connection.open_wire

    def opened(*place):
        found.append(sys.stdout)
        return open_wire(*place)

    monkeypatch.setattr(connection, "open_wire", opened)
    Connection(f"udpin:127.0.0.1:{ports[0]}").close()
    assert found == [sys.stdout]


def test_a_peer_that_reads_nothing_keeps_nobody_waiting():
    ours, theirs = socket.socketpair()
    with ours, theirs:
        ours.setblocking(False)
        end = connection.Wire(ours)
        for _ in range(100):
            end.write(bytes(100_000))
        assert theirs.recv(1) == bytes(1)


def test_a_second_program_takes_no_messages_from_the_first(pair, ports):
    ours, theirs = pair
    with pytest.raises(LinkError, match="another program receives there"):
        Connection(f"udpin:127.0.0.1:{ports[0]}")
    theirs.send(heartbeat())
    assert len(received(ours)) == 1


@pytest.mark.parametrize(
    ("address", "words"),
    [
        ("bluetooth:7", "must be udpin:HOST:PORT"),
        ("udpin:127.0.0.1", "must be udpin:HOST:PORT"),
        ("udpin:127.0.0.1:http", "must be udpin:HOST:PORT"),
        ("tcp::5760", "must be udpin:HOST:PORT"),
        ("udpin:127.0.0.1:0", "must be from 1 to 65535"),
        ("udpout:127.0.0.1:70000", "must be from 1 to 65535"),
    ],
)
def test_an_address_of_another_form_is_refused(address, words):
    with pytest.raises(LinkRefusedError, match=words) as caught:
        Connection(address)
    assert repr(address) in str(caught.value)


def test_what_cannot_be_opened_says_why(ports):
    with pytest.raises(LinkError, match=r"cannot be opened.*refused"):
        Connection(f"tcp:127.0.0.1:{ports[1]}")
    with pytest.raises(LinkError, match="cannot be opened"):
        Connection("serial:/dev/no_such_port:57600")


def test_lost_messages_are_counted_and_late_ones_are_not(pair):
    ours, theirs = pair
    ours.watched = 3
    for number in (250, 251, 254, 253, 254, 2):
        theirs._wire.mav.seq = number
        theirs.send(heartbeat())
    assert len(received(ours, 6)) == 6
    assert ours.lost == 2 + 3  # 252 and 253; 255, 0 and 1


def test_messages_that_are_not_known_here_are_not_lost(pair):
    """A newer autopilot sends some beside each of those that are known."""
    ours, theirs = pair
    ours.watched, parser = 3, theirs._wire.mav
    for number in range(0, 12, 3):
        parser.seq = number
        theirs.send(heartbeat())
        for other in (number + 1, number + 2):
            header = bytes([0xFD, 4, 0, 0, other, 3, 1, *(60000).to_bytes(3, "little")])
            theirs._wire.write(header + bytes(6))
    parser.seq = 14  # 12 and 13 are lost
    theirs.send(heartbeat())
    assert len(received(ours, 5)) == 5
    assert ours.lost == 2


def test_a_closed_connection_says_so(pair):
    ours, _ = pair
    ours.close()
    with pytest.raises(LinkError, match="is closed"):
        ours.receive(0.0)
    ours.send(heartbeat())  # to nobody


def test_bad_frames_pass_for_nothing_and_cost_no_good_one(pair):
    """Mutated frames, each followed by a good one."""
    ours, theirs = pair
    random_, taken, parser = random.Random(1), [], theirs._wire.mav
    for number in range(FRAMES):
        good = heartbeat().pack(parser)
        parser.seq = (parser.seq + 1) % 256
        taken += ours.parse(changed(random_, good))
        after = ours.parse(good)
        assert [message.get_type() for message in after] == ["HEARTBEAT"], number
    # A frame cut to pieces may hold a whole good one. Of what was changed at random the checksum of
    # 16 bits lets one in 65 536 pass.
    strange = [each for each in taken if each.to_dict() != heartbeat().to_dict()]
    assert len(strange) <= 5


@pytest.fixture
def key(tmp_path):
    path = tmp_path / "key"
    path.write_bytes(bytes(range(KEY_LENGTH)))
    return str(path)


def test_signed_messages_are_taken_and_others_are_not(ports, key, tmp_path):
    address = f"127.0.0.1:{ports[0]}"
    hexadecimal = tmp_path / "hexadecimal"
    hexadecimal.write_text(bytes(range(KEY_LENGTH)).hex() + "\n", encoding="ascii")
    ours = Connection(f"udpin:{address}", key=key)
    signing = Connection(f"udpout:{address}", component=1, key=str(hexadecimal))
    for sender, receiver in ((signing, ours), (ours, signing)):
        sender.send(heartbeat())
        assert len(received(receiver)) == 1
    plain = Connection(f"udpout:{address}", component=1)
    plain.send(heartbeat())
    assert received(ours, timeout=0.3) == []
    assert ours.bad == 1
    for each in (ours, signing, plain):
        each.close()


def test_a_key_of_another_length_is_refused(tmp_path):
    (tmp_path / "key").write_text("secret", encoding="ascii")
    for name, words in {"key": "must hold 32 bytes", "nothing": "cannot be read"}.items():
        with pytest.raises(LinkRefusedError, match=words):
            Connection("udpin:127.0.0.1:14999", key=str(tmp_path / name))


def test_values_are_told_by_their_names():
    assert name_of("MAV_TYPE", 1) == "FIXED_WING"
    assert name_of("MAV_RESULT", 77) == "77"
