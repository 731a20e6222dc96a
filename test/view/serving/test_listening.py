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

"""Where a page listens, and what it says where it cannot."""

import socket

import pytest

from uav_tracking_mpc.view.serving import listening
from uav_tracking_mpc.view.serving.listening import address_of, listen


def test_a_port_that_is_taken_is_told():
    with listen(port=0) as first:
        port = first.getsockname()[1]
        with pytest.raises(OSError, match=rf"port {port} of 127\.0\.0\.1 is taken"):
            listen(port=port)


def test_without_a_port_the_next_free_one_is_taken(monkeypatch):
    with listen(port=0) as first:
        taken = first.getsockname()[1]
        monkeypatch.setattr(listening, "PORT", taken)
        with listen() as second:
            assert taken < second.getsockname()[1] < taken + listening.TRIES
        monkeypatch.setattr(listening, "TRIES", 1)
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
        scheme, _, place = address_of(listener, host).partition("://")
        name, _, port = place.rpartition(":")
        assert (scheme, name) == ("http", host)
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
