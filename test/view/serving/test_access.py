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
    assert access.refusal("/", [HERE], [], [f"theme=dark; {name}={rest.partition(';')[0]}"]) == ""
    for wrong in (f"{name}=wrong", "uav_tracking=secret"):
        assert "token" in access.refusal("/", [HERE], [], [wrong])
    assert "HttpOnly" in rest and "SameSite=Strict" in rest
    assert name != Access("other").cookie.partition("=")[0]


def test_every_token_is_new():
    assert new_token() != new_token()
    assert len(new_token()) >= 32
