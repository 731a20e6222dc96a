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

"""A scene that is drawn for nobody, and what was sent to it."""

import pytest

viser = pytest.importorskip("viser")


@pytest.fixture(scope="module")
def server():
    server = viser.ViserServer("127.0.0.1", verbose=False)
    yield server
    server.stop()


@pytest.fixture
def scene(server):
    yield server.scene
    server.scene.reset()


@pytest.fixture
def sent(scene, monkeypatch):
    """Messages about nodes from now on."""
    messages, queue = [], scene._websock_interface.queue_message

    def queue_message(message):
        messages.append(message)
        queue(message)

    monkeypatch.setattr(scene._websock_interface, "queue_message", queue_message)
    return messages


@pytest.fixture
def node(scene):
    """The node of a name below the root of the aircraft."""

    def find(name):
        handle = scene.get_handle_by_name(f"/world/aircraft/{name}")
        assert handle is not None, f"there is no node {name}"
        return handle

    return find


@pytest.fixture
def draw(scene):
    """An element that draws a flight."""

    def begin(kind, flight):
        return kind(scene, f"/world/{flight.name}", flight, (0, 114, 178))

    return begin
