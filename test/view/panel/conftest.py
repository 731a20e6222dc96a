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

import asyncio
import contextlib
import io
from concurrent.futures import ThreadPoolExecutor

import pytest
from processes import PATIENCE, wait_for

viser = pytest.importorskip("viser")
from viser._messages import GuiUpdateMessage  # noqa: E402
from watched_flight_stand_in import StandInClient, StandInFlight, StandInSource, StandInSteering  # noqa: E402


class Panel:
    """A part on a real server, and hands on its widgets."""

    def __init__(self, server, part, flight, clock=None):
        self.gui, self.flight, self.source = server.gui, flight, StandInSource(flight)
        self.source.clock = clock
        self.client = server._connected_clients[0] = StandInClient()
        self.part = part(server.gui, flight, self.source)

    def show(self, *sights):
        """Show what the flight shows now, or each of the next sights, as HTML."""
        for seen in sights:
            self.flight.seen.append(seen)
            self.part.show(seen)
        self.part.show(self.flight.sight)
        return self.text

    def shown(self, *sights):
        """This, having shown that."""
        self.show(*sights)
        return self

    @property
    def text(self):
        """All HTML that is visible."""
        return "\n".join(
            handle.content for handle in self._handles() if handle.visible and _is_html(handle)
        )

    def widget(self, label):
        """The widget of a label."""
        (found,) = (w for w in self._handles() if getattr(w._impl.props, "label", None) == label)
        return found

    def labels(self):
        return {getattr(handle._impl.props, "label", None) for handle in self._handles()} - {None}

    def by_hand(self, label, value):
        """Do what a browser does whose user sets a widget, or presses a button (True)."""
        self.send(label, value)
        self.gui._thread_executor.submit(lambda: None).result(PATIENCE)  # behind the callbacks

    def send(self, label, value):
        """Do that, but do not wait for the callbacks."""
        message = GuiUpdateMessage(self.widget(label)._impl.uuid, {"value": value})
        asyncio.run_coroutine_threadsafe(
            self.gui._handle_gui_updates(0, message), self.gui._event_loop
        ).result(PATIENCE)

    def until(self, condition):
        """Show it until something is so."""
        assert wait_for(lambda: self.show() is not None and condition()), self.text

    def _handles(self, container="root"):
        for handle in self.gui._container_handle_from_uuid[container]._children.values():
            yield handle
            if handle._impl.uuid in self.gui._container_handle_from_uuid:
                yield from self._handles(handle._impl.uuid)


def _is_html(handle):
    return isinstance(handle, viser.GuiHtmlHandle)


@pytest.fixture(scope="package")
def _one_server():
    with contextlib.redirect_stdout(io.StringIO()):
        server = viser.ViserServer("127.0.0.1", 18080, verbose=False)
    server.gui._thread_executor = ThreadPoolExecutor(1)  # one callback after the other
    yield server
    server.stop()


@pytest.fixture
def server(_one_server):
    """On a loopback port, and empty."""
    yield _one_server
    _one_server.gui.reset()
    _one_server._connected_clients.clear()


@pytest.fixture
def flight():
    """An aircraft that can be steered in every way."""
    return StandInFlight(steering=StandInSteering())


@pytest.fixture
def panel(server, flight):
    """Puts a part on the server."""
    return lambda part, clock=None: Panel(server, part, flight, clock)
