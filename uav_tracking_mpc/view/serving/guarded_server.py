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

"""viser's server behind checks of who may open a page.

A browser lets every site that its user visits send requests to the user's own machine. Without a
check such a site could open the page's websocket and steer an aircraft. Hence each request must
name this machine as its ``Host`` (a site whose name was made to resolve to this machine names
itself), and an ``Origin``, which browsers send with every websocket, must be the page's own. Other
users and programs of this machine can name both, hence a token is asked for as well.

viser answers whoever connects. It serves files and websockets of one port through
``websockets.asyncio.server.serve``, whose ``process_request`` sees each request before anything
else: the check stands there, so that no second port is open behind it. viser offers no way to pass
it, hence ``serve`` is wrapped for the moment in which viser calls it. A version of viser that
serves in another way is noticed and not used.

Every page carries a Content-Security-Policy: the browser itself keeps the page from asking anything
of other machines, from being shown inside another site, and from being pointed at another server by
its address (``?websocket=...``), whose content would then run as this page's.
"""

from __future__ import annotations

import asyncio
import contextlib
import errno
import gzip
import hashlib
import hmac
import inspect
import ipaddress
import logging
import re
import secrets
import socket
import threading
import warnings
from collections.abc import Awaitable, Callable, Collection, Iterator, Mapping, Sequence
from http import HTTPStatus
from typing import Any
from urllib.parse import parse_qs, urlsplit

import rich
import viser
import websockets.asyncio.server
from viser._messages import Message
from websockets.asyncio.server import ServerConnection
from websockets.http11 import Request, Response

from uav_tracking_mpc.view.serving.page_script import with_script

HOST = re.compile(r"(?P<name>\[[0-9A-Fa-f:.]+\]|[A-Za-z0-9._-]+)(:[0-9]{1,5})?")
TOKEN_BYTES = 24


def new_token() -> str:
    """A token that nobody can guess."""
    return secrets.token_urlsafe(TOKEN_BYTES)


class Access:
    """Decides about requests.

    Args:
        token: What a request must know, in its address or as a cookie.
        names: By which browsers may address this machine, beside ``localhost`` and IP addresses.
    """

    def __init__(self, token: str, names: Collection[str] = ()) -> None:
        self._token = token
        # Cookies are shared by all ports of a host: each server has a name of its own for its one.
        self._cookie_name = f"uav_tracking_{hashlib.sha256(token.encode()).hexdigest()[:8]}"
        self._names = {"localhost", *(name.lower() for name in names)}

    def refusal(
        self, path: str, hosts: Sequence[str], origins: Sequence[str], cookies: Sequence[str]
    ) -> str:
        """Why a request is refused, in words; empty where it is allowed.

        Args:
            path: That was asked for, with its query.
            hosts: All values of the header ``Host``.
            origins: All values of the header ``Origin``; programs that are no browsers send none.
            cookies: All values of the header ``Cookie``.
        """
        if len(hosts) != 1 or not self._is_known(hosts[0]):
            return "this page does not answer to that host name; open the address that was printed"
        if len(origins) > 1 or any(not _is_own(origin, hosts[0]) for origin in origins):
            return "other sites may not use this page"
        if self.knows_token(path) or self._in_cookies(cookies):
            return ""
        return "this page asks for its token; open the address that was printed, with ?token=..."

    def knows_token(self, path: str) -> bool:
        """Whether an address holds the right token.

        Args:
            path: That was asked for, with its query.
        """
        given = parse_qs(urlsplit(path).query).get("token", [])
        return any(_same(word, self._token) for word in given)

    @property
    def cookie(self) -> str:
        """Value of ``Set-Cookie`` by which a browser keeps the token; scripts cannot read it."""
        return f"{self._cookie_name}={self._token}; Path=/; HttpOnly; SameSite=Strict"

    def _in_cookies(self, cookies: Sequence[str]) -> bool:
        # Those of all programs on this host come along; a reader of cookies would refuse them all
        # for one that is not well formed.
        pairs = (pair.strip().partition("=") for text in cookies for pair in text.split(";"))
        known = (value for name, _, value in pairs if name == self._cookie_name)
        return any(_same(value, self._token) for value in known)

    def _is_known(self, host: str) -> bool:
        found = HOST.fullmatch(host)
        if found is None:
            return False
        name = found["name"].lower()
        if name in self._names:
            return True
        try:
            ipaddress.ip_address(name.strip("[]"))
        except ValueError:
            return False
        return True


def _is_own(origin: str, host: str) -> bool:
    """Whether an origin is the page's; behind a proxy it may be https."""
    return origin.lower() in (f"http://{host.lower()}", f"https://{host.lower()}")


def _same(given: str, wanted: str) -> bool:
    return hmac.compare_digest(given.encode(errors="surrogateescape"), wanted.encode())


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


logger = logging.getLogger(__name__)

LARGEST = 2**20  # bytes of a message: a page sends a file in pieces of half of it
HEAD_TIME = 10.0  # s within which a client must have sent its request
HEADERS = {
    "X-Frame-Options": "DENY",
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",  # the token is part of the address
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cache-Control": "no-store",
}
POLICY = (
    "default-src 'self' 'unsafe-inline' 'unsafe-eval' data: blob:; "
    "connect-src 'self' ws://{host} wss://{host} data: blob:; "
    "frame-ancestors 'none'; base-uri 'none'; form-action 'none'"
)

Answer = Response | None
Answering = Callable[[Mapping[str, list[str]]], str]
ProcessRequest = Callable[[ServerConnection, Request], Awaitable[Answer] | Answer]

_serving = threading.Lock()


class GuardedServer(viser.ViserServer):
    """A viser server that answers to whom it should.

    Args:
        host: Address to listen at; without one 127.0.0.1.
        port: See :func:`listen`.
        label: Title of the panel.

    Attributes:
        address: Where a browser finds the page, with the token.
        answers: By path, what makes JSON of a query; asked in the loop that serves, after the
            checks, so that it must be quick.

    Raises:
        OSError: There is no listening at this address; says why.
    """

    def __init__(self, host: str | None = None, port: int | None = None, label: str = "") -> None:
        listener = listen(host or LOOPBACK, port)
        token = new_token()
        self.address = f"{address_of(listener, host or LOOPBACK)}/?token={token}"
        machine = socket.gethostname()
        names = () if host is None else (host, machine, f"{machine}.local")
        self.answers: dict[str, Answering] = {}
        # A page may be closed while a frame is drawn for it, which is nobody's mistake.
        warnings.filterwarnings("ignore", "Queued a .* on a closed connection")
        guard = _Guard(Access(token, names), listener, self.answers)
        with _silent(), guard.around_serve():
            super().__init__(LOOPBACK, listener.getsockname()[1], label=label, verbose=False)
        if not guard.serves:
            self.stop()
            listener.close()
            raise RuntimeError(
                f"viser {viser.__version__} does not serve as version 1.1 does: nothing would "
                "check who opens the page"
            )

    def request_share_url(self, verbose: bool = True) -> str | None:
        """Refuse: viser would show the page to whoever finds it, through a machine of others.

        Args:
            verbose: Of viser; not used.
        """
        logger.warning("page: refused to share it through share.viser.studio")
        return None

    def stop(self) -> None:
        """Stop serving."""
        with _silent():
            super().stop()


class _Guard:
    """Stands in for viser's ``process_request``, on a socket that is already bound."""

    def __init__(
        self, access: Access, listener: socket.socket, answers: Mapping[str, Answering]
    ) -> None:
        self._access, self._listener = access, listener
        self._told: set[str] = set()
        self._pages: dict[bool, bytes] = {}  # with the script, by whether they are compressed
        self.answers = answers
        self.serves = False

    @contextlib.contextmanager
    def around_serve(self) -> Iterator[None]:
        """Let the next call of ``serve`` go through this guard."""
        with _serving:
            serve = websockets.asyncio.server.serve

            def guarded(handler: Any, *_: Any, process_request: ProcessRequest, **rest: Any) -> Any:
                self.serves = True
                rest |= {"open_timeout": HEAD_TIME, "logger": _quiet_logger()}
                rest |= {"max_size": LARGEST, "create_connection": self._connection}
                return serve(
                    handler,
                    sock=self._listener,
                    process_request=self._checked(process_request),
                    **rest,
                )

            websockets.asyncio.server.serve = guarded  # type: ignore[assignment,misc]
            try:
                yield
            finally:
                websockets.asyncio.server.serve = serve  # type: ignore[misc]

    def _checked(self, answer: ProcessRequest) -> ProcessRequest:
        async def checked(connection: ServerConnection, request: Request) -> Response | None:
            headers, path = request.headers, request.path
            hosts = headers.get_all("Host")
            refusal = self._access.refusal(
                path, hosts, headers.get_all("Origin"), headers.get_all("Cookie")
            )
            if headers.get("Upgrade") == "websocket" and f"viser-v{viser.__version__}" not in (
                headers.get_all("Sec-WebSocket-Protocol")
            ):
                refusal = refusal or "this page is of another version of viser; load it again"
            if refusal:
                self._refuse(refusal, connection)
                return connection.respond(HTTPStatus.FORBIDDEN, f"{refusal}\n")
            response = self._own_answer(connection, request)
            if response is None:
                answered = answer(connection, request)
                response = await answered if inspect.isawaitable(answered) else answered
            if response is not None:
                if response.headers.get("Content-Type", "").startswith("text/html"):
                    self._put_script(response)
                response.headers.update(HEADERS)
                response.headers["Content-Security-Policy"] = POLICY.format(host=hosts[0])
                if self._access.knows_token(path):
                    response.headers["Set-Cookie"] = self._access.cookie
            return response

        return checked

    def _own_answer(self, connection: ServerConnection, request: Request) -> Answer:
        """What the script of the page asks for; None for all else."""
        if request.headers.get("Upgrade") == "websocket":
            return None
        parts = urlsplit(request.path)
        if parts.path not in self.answers:
            return None
        try:
            text = self.answers[parts.path](parse_qs(parts.query))
        except Exception as error:  # a page that is told nothing says so itself
            self._tell(f"{parts.path} was not answered: {error!r}")
            return connection.respond(HTTPStatus.INTERNAL_SERVER_ERROR, "not answered\n")
        response = connection.respond(HTTPStatus.OK, text)
        del response.headers["Content-Type"]
        response.headers["Content-Type"] = "application/json"
        return response

    def _put_script(self, response: Response) -> None:
        """Serve the page of viser with the script in it; it is made once in each encoding."""
        zipped = response.headers.get("Content-Encoding") == "gzip"
        if zipped not in self._pages:
            body = gzip.decompress(response.body) if zipped else response.body
            page = with_script(bytes(body).decode()).encode()
            self._pages[zipped] = gzip.compress(page) if zipped else page
        response.body = self._pages[zipped]
        del response.headers["Content-Length"]
        response.headers["Content-Length"] = str(len(response.body))

    def _connection(self, *args: Any, **kwargs: Any) -> ServerConnection:
        """A websocket whose messages are those of a page; called in the loop that reads them."""
        asyncio.get_running_loop().set_exception_handler(
            lambda _, context: self._tell(f"a message failed: {context.get('exception')!r}")
        )
        return _Checked(self._refuse, *args, **kwargs)

    def _refuse(self, refusal: str, connection: ServerConnection) -> None:
        self._tell(f"refused a request of {connection.remote_address[0]}: {refusal}")

    def _tell(self, words: str) -> None:
        """Log the same once: whoever asks again and again does not fill the log."""
        if words not in self._told:
            self._told.add(words)
            logger.warning("page: %s", words)


class _Checked(ServerConnection):
    """A websocket that hands on what viser can read; its own consumer ends at anything else.

    Args:
        refuse: Takes why a message was refused, and this websocket.
        args: Of websockets.
        kwargs: Of websockets.
    """

    def __init__(
        self, refuse: Callable[[str, ServerConnection], None], *args: Any, **kwargs: Any
    ) -> None:
        super().__init__(*args, **kwargs)
        self._refuse = refuse

    async def recv(self, decode: bool | None = None) -> Any:
        """The next message that viser can read.

        Args:
            decode: Of websockets.
        """
        while True:
            raw: Any = await super().recv(decode)
            try:
                Message.deserialize(raw)
            except Exception:  # of msgspec, or of viser's own making
                self._refuse("its message is none that a page sends", self)
            else:
                return raw


def _quiet_logger() -> logging.Logger:
    """For websockets, which else logs each file that is served and each client that goes away."""
    quiet = logging.getLogger(f"{__name__}.websockets")
    quiet.setLevel(logging.ERROR)
    if not quiet.filters:
        quiet.addFilter(lambda record: record.getMessage() != "opening handshake failed")
    return quiet


@contextlib.contextmanager
def _silent() -> Iterator[None]:
    """Without viser's words on stdout, which it prints through the console of rich."""
    console = rich.get_console()
    before, console.quiet = console.quiet, True
    try:
        yield
    finally:
        console.quiet = before
