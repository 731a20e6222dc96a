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

"""Who may open a page: the checks that a request passes before the page's server sees it.

A browser lets every site that its user visits send requests to the user's own machine. Without a
check such a site could open the page's websocket and steer an aircraft. Hence each request must
name this machine as its ``Host`` (a site whose name was made to resolve to this machine names
itself), and an ``Origin``, which browsers send with every websocket, must be the page's own. Other
users and programs of this machine can name both, hence a token is asked for as well.
"""

from __future__ import annotations

import hashlib
import hmac
import ipaddress
import re
import secrets
from collections.abc import Collection, Sequence
from http.cookies import CookieError, SimpleCookie
from urllib.parse import parse_qs, urlsplit

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

    @property
    def _cookie_name(self) -> str:
        # Cookies are shared by all ports of a host: each server has a name of its own for its one.
        return f"uav_tracking_{hashlib.sha256(self._token.encode()).hexdigest()[:8]}"

    def _in_cookies(self, cookies: Sequence[str]) -> bool:
        for text in cookies:
            try:
                kept = SimpleCookie(text).get(self._cookie_name)
            except CookieError:
                continue
            if kept is not None and _same(kept.value, self._token):
                return True
        return False

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
