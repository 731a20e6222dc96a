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

"""The socket at which a page listens, and the address under which a browser finds it."""

from __future__ import annotations

import errno
import ipaddress
import socket

LOOPBACK = "127.0.0.1"
PORT = 8080
TRIES = 20  # ports from PORT on


def listen(host: str = LOOPBACK, port: int | None = None) -> socket.socket:
    """Listen at an address.

    Args:
        host: Address or name of this machine.
        port: Port; 0 is any free one, and without one it is the first free one from 8080 on.

    Raises:
        OSError: It is taken, or no address of this machine; says so in words.
    """
    try:
        family, *_ = socket.getaddrinfo(host, port or PORT, type=socket.SOCK_STREAM)[0]
    except (OSError, UnicodeError):
        raise OSError(f"--host {host!r} is neither an address nor a known name") from None
    ports = range(PORT, PORT + TRIES) if port is None else (port,)
    for candidate in ports:
        try:
            return socket.create_server((host, candidate), family=family)
        except OSError as error:
            if error.errno == errno.EADDRINUSE:
                continue
            reason = error.strerror or str(error)
            raise OSError(f"cannot listen at {host} port {candidate}: {reason}") from None
    if port is None:
        raise OSError(f"ports {PORT} to {PORT + TRIES - 1} of {host} are taken: choose a --port")
    raise OSError(f"port {port} of {host} is taken: end what listens there, or choose a --port")


def address_of(listener: socket.socket, host: str) -> str:
    """Where a browser finds a page.

    Args:
        listener: Of :func:`listen`.
        host: As it was asked for; for one that means every address, one of them is told.

    Returns:
        As ``http://127.0.0.1:8080``.
    """
    bound, port = listener.getsockname()[:2]
    if ipaddress.ip_address(bound.partition("%")[0]).is_unspecified:
        host = _own_address(listener.family)
    return f"http://[{host}]:{port}" if ":" in host else f"http://{host}:{port}"


def _own_address(family: int) -> str:
    """Address from which this machine would reach others; nothing is sent to learn it."""
    six = family == socket.AF_INET6
    with socket.socket(family, socket.SOCK_DGRAM) as probe:
        try:
            probe.connect(("2001:db8::1" if six else "192.0.2.1", 9))  # for documentation alone
        except OSError:
            return "::1" if six else LOOPBACK
        return str(probe.getsockname()[0])
