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

"""A page that looks back sees a scene of that time, and the shared one again afterwards."""

from types import SimpleNamespace

import pytest
from watched_flight_stand_in import StandInFlight, StandInSteering, sight

pytest.importorskip("viser")

from uav_tracking_mpc.view.flight_history import FlightHistory
from uav_tracking_mpc.view.looking_back import PAST_WORLD, LookingBack, PastFlight
from uav_tracking_mpc.view.serving.guarded_server import GuardedServer

WORLD = "/world"


@pytest.fixture
def flown():
    """A flight of 30 s, and what was kept of it."""
    flight = StandInFlight(steering=StandInSteering())
    history = FlightHistory(flight)
    for time in range(31):
        flight.seen.append(sight(float(time)))
        history.note(flight.sight)
    return flight, history


def test_a_past_flight_shows_its_time_and_cannot_be_steered(flown):
    past = PastFlight(*flown)
    assert past.sight is None and past.past(5.0) == []
    assert past.go_to(12.4).time == 12.0
    assert past.sight.time == 12.0
    assert [seen.time for seen in past.past(3.0)] == [10.0, 11.0, 12.0]
    assert past.steering is None
    assert past.tracking == flown[0].tracking


def test_the_shared_scene_is_hidden_while_the_past_is_seen(flown):
    server = GuardedServer(port=0)
    try:
        client = SimpleNamespace(scene=server.scene, atomic=server.atomic)
        shared = server.scene.add_frame(WORLD)
        begun, shown = [], []

        def draw(scene, root, flight):
            begun.append(root)
            return lambda seen: shown.append(seen.time)

        back = LookingBack(client, WORLD, draw)
        flights = {"aircraft": flown}
        for time in (None, 7.0, 7.0, 20.5, None):
            back.show(time, flights)
            assert back.frame.visible is (time is not None)
            assert shared.visible is (time is None)
            assert set(back.watched) == (set() if time is None else {"aircraft"})
        assert begun == [f"{PAST_WORLD}/aircraft"]
        assert shown == [7.0, 20.0]  # once each: what stands is not sent again
    finally:
        server.stop()
