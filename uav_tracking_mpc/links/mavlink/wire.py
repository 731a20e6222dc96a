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

"""Sockets and serial ports that never block once they are open; opening one has a deadline."""

from __future__ import annotations

import contextlib
import errno
import os
import select
import socket
from typing import Any

OPEN_LIMIT = 2.0  # s to reach the other end of a stream
DATAGRAM_SIZE = 65535  # bytes
FIRST_BAUD = 1200  # a serial port is opened with it: some kernels miss a rate that does not change


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
    """UDP: answers all who were heard where it listens, else speaks to one.

    Args:
        address: Host and port.
        listens: Whether it is bound there, for itself alone: a second program that received
            there would take messages from the first.
    """

    def __init__(self, address: tuple[str, int], listens: bool) -> None:
        super().__init__(socket.socket(socket.AF_INET, socket.SOCK_DGRAM))
        self.port.setblocking(False)
        self._listens, self._peers = listens, set[tuple[str, int]]()
        try:
            if listens:
                self.port.bind(address)
            else:
                self._peers.add((socket.gethostbyname(address[0]), address[1]))
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
            self._peers.add(peer)
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
    client = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
    client.settimeout(OPEN_LIMIT)
    try:
        client.connect((host, number))
    except OSError:
        client.close()
        raise
    return Wire(_quick(client))


def words_of(error: Exception) -> str:
    """Why a wire cannot be opened.

    Args:
        error: As raised by :func:`open_wire`.
    """
    if isinstance(error, OSError) and error.errno == errno.EADDRINUSE:
        return "another program receives there, and would lose messages; end it or take another"
    return str(error)


def _quick(stream: socket.socket) -> socket.socket:
    """A stream that neither blocks nor collects frames."""
    stream.setblocking(False)
    stream.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    return stream
