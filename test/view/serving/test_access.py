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

"""Which requests may reach a page: Host, Origin and token."""

import pytest

from uav_tracking_mpc.view.serving.access import Access, new_token

HERE = "127.0.0.1:8080"


def asked(access, path="/", host=HERE, origin=None, cookie=None):
    return access.refusal(
        path, [host], [] if origin is None else [origin], [] if cookie is None else [cookie]
    )


WITH = "/?token=secret"


@pytest.mark.parametrize("host", [HERE, "localhost:8080", "LOCALHOST", "[::1]:8080", "127.0.0.2"])
def test_loopback_needs_the_token(host):
    assert "token" in asked(Access("secret"), host=host)
    assert asked(Access("secret"), WITH, host=host) == ""
    assert asked(Access("secret"), WITH, host=host, origin=f"http://{host}") == ""


@pytest.mark.parametrize("host", ["rebound.example:8080", "", "127.0.0.1.example", "a b", "[::1"])
def test_names_of_others_are_refused(host):
    assert "host name" in asked(Access("secret"), WITH, host=host)


def test_a_request_names_one_host():
    assert "host name" in Access("secret").refusal(WITH, [], [], [])
    assert "host name" in Access("secret").refusal(WITH, [HERE, HERE], [], [])


@pytest.mark.parametrize(
    "origin",
    [
        "http://site.example",
        "http://127.0.0.1:3000",
        "http://localhost:8080",
        "null",
        "",
        "file://",
    ],
)
def test_other_sites_are_refused(origin):
    assert "other sites" in asked(Access("secret"), WITH, origin=origin)


def test_two_origins_are_refused():
    assert "other sites" in Access("secret").refusal(WITH, [HERE], [f"http://{HERE}"] * 2, [])


def test_with_a_token_nobody_passes_without_it():
    access = Access("secret", names=["robot"])
    assert "token" in asked(access)
    assert "token" in asked(access, "/?token=wrong")
    assert "token" in asked(access, "/?token=")
    assert "token" in asked(access, "/?token=secre%C3%A9")
    assert "token" in asked(access, "/?token=\udcff")
    assert "token" in asked(access, cookie="uav_tracking=secret")
    assert asked(access, "/?token=secret") == ""


def test_the_cookie_stands_for_the_token():
    access = Access("secret")
    assert asked(access, cookie="theme=dark; " + access.cookie.partition(";")[0]) == ""
    assert "token" in asked(access, cookie=access.cookie.partition("=")[0] + "=wrong")
    assert "HttpOnly" in access.cookie
    assert "SameSite=Strict" in access.cookie
    assert access.cookie.partition("=")[0] != Access("other").cookie.partition("=")[0]


def test_a_token_does_not_excuse_a_foreign_site():
    access = Access("secret", names=["robot"])
    assert "other sites" in asked(access, "/?token=secret", origin="http://site.example")
    assert "host name" in asked(access, "/?token=secret", host="rebound.example:8080")


def test_with_a_token_the_machine_goes_by_its_names_and_addresses():
    access = Access("secret", names=["Robot"])
    for host in ("robot:8080", "192.168.1.7:8080", "[fd00::7]:8080", "localhost"):
        assert asked(access, "/?token=secret", host=host) == ""


def test_every_token_is_new():
    assert new_token() != new_token()
    assert len(new_token()) >= 32
