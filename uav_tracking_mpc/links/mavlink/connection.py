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

"""Bytes to messages and back: one end of a MAVLink connection.

Everything that comes over a wire may be late, doubled, cut or garbled, so nothing that arrives
raises: what is no message is counted and dropped. Sockets and serial ports never block once they
are open; opening one has a deadline.
"""

from __future__ import annotations

import contextlib
import errno
import os
import select
import socket
import threading
import time
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

from uav_tracking_mpc.links import LinkError, LinkRefusedError
from uav_tracking_mpc.links.mavlink.dialect import mavlink

OPEN_LIMIT = 2.0  # s to reach the other end of a stream
DATAGRAM_SIZE = 65535  # bytes
PEER_AGE = 10.0  # s that a peer may be silent while others speak
FIRST_BAUD = 1200  # baud, opens a serial port: some kernels miss a rate that does not change


class Wire:
    """A byte stream: the other end of a TCP connection, or a serial port.

    Args:
        port: What has a file descriptor, which does not block.

    Attributes:
        mav: Parser and packer of messages, which writes to this wire.
    """

    mav: Any = None

    def __init__(self, port: Any) -> None:
        self.port = port

    def select(self, timeout: float) -> bool:
        """Whether there is something to read, or the other end is gone.

        Args:
            timeout: How long to wait for it in [s].
        """
        return bool(select.select([self.port], [], [], timeout)[0])

    def recv(self, size: int) -> bytes | None:
        """Bytes that have come: None if there are none, empty where the stream has ended.

        Args:
            size: How many at most.
        """
        try:
            return os.read(self.port.fileno(), size)
        except BlockingIOError:
            return None

    def write(self, frame: bytes) -> None:
        """Send a frame; one that the other end has no room for is lost.

        Args:
            frame: Packed message.
        """
        with contextlib.suppress(OSError):  # whoever receives is told of a lost wire
            os.write(self.port.fileno(), frame)

    def close(self) -> None:
        """Let go of the port."""
        self.port.close()


class ListeningWire(Wire):
    """A TCP server with one client at a time; when it leaves, the next may come.

    Args:
        address: Host and port to listen at.
    """

    def __init__(self, address: tuple[str, int]) -> None:
        self._listener = socket.create_server(address, backlog=1)
        self._listener.setblocking(False)
        super().__init__(self._listener)

    def recv(self, size: int) -> bytes | None:
        """See :meth:`Wire.recv`: never empty."""
        if self.port is self._listener:
            with contextlib.suppress(OSError):  # the client may have left already
                self.port = _quick(self._listener.accept()[0])
            return None
        data: bytes | None = b""
        with contextlib.suppress(OSError):
            data = super().recv(size)
        if data == b"":
            self.port.close()
            self.port = self._listener
        return data or None

    def close(self) -> None:
        """See :meth:`Wire.close`."""
        super().close()
        self._listener.close()


class DatagramWire(Wire):
    """UDP: answers all who were heard of late where it listens, else speaks to one.

    A simulation that starts again, or a router, comes from another port. While nobody speaks, all
    who spoke last are answered: the way to an aircraft may be open though the way back is not.

    Args:
        address: Host and port.
        listens: Whether it is bound there, for itself alone: a second program that received
            there would take messages from the first.
    """

    def __init__(self, address: tuple[str, int], listens: bool) -> None:
        super().__init__(socket.socket(socket.AF_INET, socket.SOCK_DGRAM))
        self.port.setblocking(False)
        self._listens, self._peers = listens, dict[tuple[str, int], float]()
        try:
            if listens:
                self.port.bind(address)
            else:
                self._peers[socket.gethostbyname(address[0]), address[1]] = 0.0
        except OSError:
            self.port.close()
            raise

    def recv(self, size: int) -> bytes | None:
        """See :meth:`Wire.recv`: a whole datagram."""
        try:
            data, peer = self.port.recvfrom(DATAGRAM_SIZE)
        except (BlockingIOError, ConnectionRefusedError):  # nobody listens there yet
            return None
        if self._listens:
            now = time.monotonic()
            if peer not in self._peers:
                self._peers = {p: last for p, last in self._peers.items() if now - last < PEER_AGE}
            self._peers[peer] = now
        return data or None

    def write(self, frame: bytes) -> None:
        """See :meth:`Wire.write`."""
        for peer in tuple(self._peers):
            with contextlib.suppress(OSError):
                self.port.sendto(frame, peer)


def open_wire(kind: str, host: str, number: int) -> Wire:
    """Open a wire, within :data:`OPEN_LIMIT` and what the resolver of names takes.

    Args:
        kind: ``udpin``, ``udpout``, ``tcp``, ``tcpin`` or ``serial``.
        host: Where it is; the device of a serial port.
        number: Of the port; the baud rate of a serial port.

    Raises:
        OSError: It cannot be opened.
        ImportError: pyserial, which serial ports need, is not installed.
    """
    if kind == "serial":
        import serial  # type: ignore[import-untyped]

        port = serial.Serial(host, FIRST_BAUD, timeout=0, exclusive=True)
        port.baudrate = number
        return Wire(port)
    if kind == "tcpin":
        return ListeningWire((host, number))
    if kind != "tcp":
        return DatagramWire((host, number), kind == "udpin")
    return Wire(_quick(socket.create_connection((host, number), OPEN_LIMIT)))


def words_of(error: Exception) -> str:
    """Why a wire cannot be opened.

    Args:
        error: As raised by :func:`open_wire`.
    """
    if isinstance(error, OSError) and error.errno == errno.EADDRINUSE:
        return "another program receives there, and would lose messages; end it or take another"
    return f"{error}: `pip install pyserial`" if isinstance(error, ImportError) else str(error)


def _quick(stream: socket.socket) -> socket.socket:
    """A stream that neither blocks nor collects frames."""
    stream.setblocking(False)
    stream.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    return stream


USUAL = "udpin:127.0.0.1:14550"
FORMS = "udpin:HOST:PORT, udpout:HOST:PORT, tcp:HOST:PORT, tcpin:HOST:PORT or serial:DEVICE:BAUD"
KEY_LENGTH = 32  # bytes of a signing key: MAVLink guide, Message Signing
CHUNK = 2048  # bytes read at once from a stream
DATAGRAM, STREAM, SERIAL = ("udpin", "udpout"), ("tcp", "tcpin"), ("serial",)
SEQUENCE = 256  # code at which the numbers of messages of one sender wrap
SIGNING_EPOCH = 1420070400.0  # s, 2015-01-01: since then signatures count units of 10 us


class Connection:
    """Messages of everybody at the other end; one thread receives, any may send.

    Args:
        address: In the forms of :data:`FORMS`; empty for :data:`USUAL`.
        component: MAVLink component that we are.
        key: File with the key that signs messages; empty for none.
        wire: Makes the wire, where it is not that of the address.
        clock: Our time in [s].

    Attributes:
        address: As above.
        now: Our time in [s].
        closed: Whether it was closed on purpose.
        lost: Messages of the watched system that never came.
        bad: Frames that were no message: garbled, cut, or wrongly signed.
        watched: System whose losses count; 0 for none.

    Raises:
        LinkRefusedError: The address has another form, or there is no such key.
        LinkError: It cannot be opened.
    """

    def __init__(
        self,
        address: str = "",
        component: int = 191,
        key: str = "",
        wire: Callable[[], Wire] | None = None,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self.address, self.now = address or USUAL, clock
        self.lost = self.bad = self.watched = 0
        self._component, self._key = component, _key(key)
        self._system = 255
        self._sending = threading.Lock()
        self._last: dict[tuple[int, int], int] = {}
        self._unknown: Counter[tuple[int, int]] = Counter()  # since the last known one
        self._begin = self.now()
        self._wire: Any = None
        place = place_of(self.address)
        self._kind, *_ = place
        self._make = wire or (lambda: open_wire(*place))
        self.open()

    def open(self) -> None:
        """Open the wire, anew if it was lost.

        Raises:
            LinkError: It cannot be opened.
        """
        self.close()
        self.closed = False
        try:
            wire = self._make()
        except Exception as error:  # of sockets, serial ports, names, numbers
            words = f"connection {self.address!r} cannot be opened"
            raise LinkError(f"{words}: {words_of(error)}") from error
        wire.mav = mavlink.MAVLink(wire, self._system, self._component)
        wire.mav.robust_parsing = True
        if self._key:
            signing = wire.mav.signing
            signing.secret_key, signing.sign_outgoing = self._key, True
            signing.timestamp = int(max(time.time() - SIGNING_EPOCH, 0.0) * 1e5)
            signing.allow_unsigned_callback = _unsigned
        self._wire = wire
        if self.closed:  # by another thread meanwhile
            self._drop()

    def close(self) -> None:
        """Let go of the wire."""
        self.closed = True
        self._drop()

    def _drop(self) -> None:
        wire, self._wire = self._wire, None
        if wire is not None:
            with contextlib.suppress(Exception):  # it may be lost already
                wire.close()

    @property
    def lost_wire(self) -> bool:
        """Whether there is no wire though nobody closed it."""
        return self._wire is None and not self.closed

    def speak_as(self, system: int) -> None:
        """Send as a component of that system from now on: the companion of its autopilot.

        Args:
            system: MAVLink system.
        """
        self._system = system
        if self._wire is not None:
            self._wire.mav.srcSystem = system

    def is_ours(self, message: Any) -> bool:
        """Whether a message with a target is for us, and not for another program on this wire.

        Args:
            message: Whose target is 0 where its sender tells none.
        """
        ours = message.target_system in (0, self._system)
        return ours and message.target_component in (0, self._component)

    @property
    def boot_time(self) -> int:
        """Since this end exists, in [ms]: what the autopilot is told as the time of a message."""
        return int((self.now() - self._begin) * 1e3) & 0xFFFFFFFF

    def wait(self, timeout: float) -> bool:
        """Whether there is something to read, or to be told of a lost wire.

        Args:
            timeout: How long to wait for it in [s].
        """
        wire = self._wire
        if wire is None:
            time.sleep(max(timeout, 0.0))
            return True
        try:
            return bool(wire.select(max(timeout, 0.0)))
        except (OSError, ValueError):  # closed meanwhile
            return True

    def receive(self, timeout: float) -> list[Any]:
        """Messages that have come, at least one unless none comes in time.

        Args:
            timeout: How long to wait in [s].

        Raises:
            LinkError: The wire is closed or lost.
        """
        wire = self._wire
        if wire is None:
            raise LinkError(f"connection {self.address!r} is closed")
        if not self.wait(timeout):
            return []
        try:
            data = wire.recv(CHUNK)
        except Exception as error:  # of sockets and serial ports
            self._drop()
            raise LinkError(f"connection {self.address!r} is lost: {error}") from error
        if data == b"":
            self._drop()
            raise LinkError(f"connection {self.address!r} is lost: the other end closed it")
        return [] if data is None else self._parse(wire.mav, data)

    def parse(self, data: bytes) -> list[Any]:
        """Messages in what came; what is none is counted and dropped.

        Args:
            data: A datagram, or the next bytes of a stream.
        """
        return self._parse(self._wire.mav, data)

    def _parse(self, parser: Any, data: bytes) -> list[Any]:
        if self._kind in DATAGRAM and parser.buf_len():
            # A frame never goes on in the next datagram: the rest of a cut one would swallow it.
            self.bad += 1
            parser.buf, parser.buf_index = bytearray(), 0
            parser.expected_length = mavlink.HEADER_LEN_V1 + 2
        try:
            messages = parser.parse_buffer(data) or []
        except Exception:  # a frame with a good checksum that cannot be unpacked
            self.bad += 1
            parser.buf, parser.buf_index = bytearray(), 0
            return []
        good = []
        for message in messages:
            if message.get_type() == "BAD_DATA":
                self.bad += 1
            elif message.get_msgId() in mavlink.mavlink_map:
                self._count(message)
                good.append(message)
            else:  # a newer autopilot's: without its definition its checksum cannot be tested
                frame = message.get_msgbuf()
                sender = frame[5:7] if frame[0] == mavlink.PROTOCOL_MARKER_V2 else frame[3:5]
                if sender[0] == self.watched:
                    self._unknown[sender[0], sender[1]] += 1
        return good

    def _count(self, message: Any) -> None:
        sender = message.get_srcSystem(), message.get_srcComponent()
        number = message.get_seq()
        if sender[0] == self.watched and sender in self._last:
            gap = (number - self._last[sender] - 1) % SEQUENCE
            if gap < SEQUENCE // 2:  # otherwise it is late or doubled
                self.lost += max(0, gap - self._unknown[sender])
        self._last[sender], self._unknown[sender] = number, 0

    def send(self, message: Any) -> None:
        """Send a message; a wire that is lost takes it without a word, receiving tells.

        Args:
            message: Of the dialect.
        """
        with self._sending:
            if (wire := self._wire) is not None:
                wire.mav.send(message)

    def relay(self, frame: bytes) -> None:
        """Send what somebody else has said on this wire.

        Args:
            frame: Packed by its sender.
        """
        with self._sending:
            if (wire := self._wire) is not None:
                wire.write(frame)


def place_of(address: str) -> tuple[str, str, int]:
    """What :func:`open_wire` is told of an address.

    Args:
        address: In the forms of :data:`FORMS`.

    Raises:
        LinkRefusedError: It has another form.
    """
    kind, _, place = address.partition(":")
    host, _, number = place.rpartition(":")
    if kind not in (*DATAGRAM, *STREAM, *SERIAL) or not host or not number.isdecimal():
        raise LinkRefusedError(f"connection is {address!r}, must be {FORMS}")
    if kind not in SERIAL and not 0 < int(number) < 65536:
        raise LinkRefusedError(f"connection is {address!r}: port {number} must be from 1 to 65535")
    return kind, host, int(number)


def _key(file: str) -> bytes:
    """Key in a file, as bytes or hexadecimal digits."""
    if not file:
        return b""
    try:
        content = Path(file).read_bytes()
    except OSError as error:
        raise LinkRefusedError(f"signing key {file!r} cannot be read: {error.strerror}") from error
    if len(content) != KEY_LENGTH:
        with contextlib.suppress(ValueError):  # is told below
            content = bytes.fromhex(content.decode("ascii", "replace").strip())
    if len(content) != KEY_LENGTH:
        raise LinkRefusedError(
            f"signing key {file!r} must hold {KEY_LENGTH} bytes, or as many hexadecimal pairs"
        )
    return content


def _unsigned(parser: Any, message: int) -> bool:
    """Whether a message counts without a signature: the radio's own, which it cannot sign."""
    return bool(message == mavlink.MAVLINK_MSG_ID_RADIO_STATUS)
