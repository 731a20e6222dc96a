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

"""What the script of a page is told, whatever it asks; what a page sees that looks back."""

import json
import math
import time
from types import SimpleNamespace

import pytest
from processes import wait_for
from watched_flight_stand_in import (
    StandInClient,
    StandInFlight,
    StandInSource,
    StandInSteering,
    sight,
)

from uav_tracking_mpc.control.fallback import FallbackMode
from uav_tracking_mpc.view.flight_history import COLUMNS, FlightHistory
from uav_tracking_mpc.view.page import Page
from uav_tracking_mpc.view.panel.mission_file import mission_of
from uav_tracking_mpc.view.visitors import PAST_WORLD, PastFlight, Visitor, alert_of, figures
from uav_tracking_mpc.view.watched_flight import CONTROLLER, SILENT, NodeStatus, PlayClock


def status(node, level, words="words"):
    return NodeStatus(node, level, words)


FINE = status("uav_simulator", 0)


@pytest.mark.parametrize(
    ("more", "level", "words"),
    [
        ({"statuses": (status(CONTROLLER, SILENT), FINE)}, 2, "The controller is silent: words"),
        ({"statuses": (status(CONTROLLER, SILENT),), "reason": "why"}, 1, "has ended, or all of"),
        ({"mode": FallbackMode.SILENCE, "reason": "no state"}, 2, "commanded: no state"),
        ({"statuses": (status("uav_simulator", 2, "the plant failed"),)}, 2, "the plant failed"),
    ],
)
def test_what_is_wrong_is_said(more, level, words):
    found = alert_of(sight(**more))
    assert found[0] == level
    assert words in found[1]


def test_all_is_well():
    assert alert_of(sight()) is None
    assert alert_of(sight(mode=None)) is None  # before the first command


def test_a_record_that_has_ended_says_so():
    clock = PlayClock(0.0, 10.0)
    clock.pause()
    assert alert_of(sight(), clock) is None
    clock.seek(10.0)
    assert alert_of(sight(), clock) == (0, "The record ends here.")


def test_the_figures_are_those_of_the_sight():
    told = figures(sight(heading=0.0), StandInFlight().tracking)
    assert told["course"] == 90.0  # east
    assert told["readings"]["Airspeed"][:3] == ["m/s", 22.5, 0.5]
    assert told["readings"]["Bank"][1] == pytest.approx(math.degrees(-0.2), rel=1e-4)
    assert set(told["readings"]) == {"Range", "Altitude", "Airspeed", "Bank", "Path angle"}
    assert told["wind"] is None
    assert told["row"][COLUMNS.index("range error")] == 0.4


@pytest.fixture
def page():
    flight = StandInFlight()
    page = Page(StandInSource(flight), None, 0)
    page.flight = flight
    yield page
    page.close()


def told(shown, **query):
    return json.loads(shown._visitors.now({name: [value] for name, value in query.items()}))


def test_before_the_first_frame_nothing_is_seen(page):
    assert told(page)["sight"] is None
    assert page._visitors.flown({"name": ["aircraft"]}) == "{}"


def test_a_frame_is_told_with_its_age(page):
    page.draw()
    now = told(page)
    assert now["name"] == "aircraft"
    assert now["sight"]["time"] == now["live"] == 10.0
    assert not now["past"]
    time.sleep(0.05)
    assert told(page)["age"] > now["age"]
    rows = json.loads(page._visitors.flown({"name": ["aircraft"]}))["rows"]
    assert [row[0] for row in rows] == [10.0]


@pytest.mark.parametrize(
    "query",
    [
        {"page": "nan"}, {"page": "-1e308"}, {"page": "x", "time": "y"},
        {"page": "7", "time": "inf"}, {"page": "0", "dark": "yes"}, {"time": "1e999"},
        {"since": "\x00"},
    ],
)  # fmt: skip
def test_junk_is_answered_as_by_a_page_that_nobody_knows(page, query):
    page.draw()
    now = told(page, **query)
    assert not now["known"] and not now["past"]
    page._visitors.flown({"name": ["aircraft"], **{name: [word] for name, word in query.items()}})
    page._visitors.flown({"name": ["no such"]})
    page.draw()


@pytest.mark.parametrize("steering", [None, StandInSteering()], ids=["nothing to steer", "flown"])
def test_a_mission_of_an_address_is_flown_for_the_page_that_asks(page, steering):
    page.flight.steering = steering
    client, text = StandInClient(), mission_of(StandInSteering(), "aircraft")
    page._visitors._visitors[7] = SimpleNamespace(client=client, show=lambda *_: None)
    page.draw()
    query = {"page": ["7"], "name": ["aircraft"], "mission": [text]}
    answers = [
        page._visitors.mission(query | more) for more in ({}, {"page": ["8"]}, {"name": [""]})
    ]
    refused = [json.loads(answer).get("refused", "") for answer in answers]
    assert [bool(words) for words in refused] == [steering is None, True, True]
    assert wait_for(lambda: steering is None or client.notifications)
    if steering is not None:
        assert "is flown" in client.notifications[0][0] and len(steering.asked) == 3


def test_what_is_not_known_is_null(page):
    nothing = {"airspeed": math.nan, "bank": math.inf, "target": None, "errors": {}}
    page.flight.seen.append(sight(11.0, **nothing))
    page.draw()
    seen = told(page)["sight"]
    assert seen["readings"]["Airspeed"] == ["m/s", None, None, 14.0, 32.0]
    assert seen["readings"]["Bank"][1] is None


WORLD = "/world"


@pytest.fixture
def flown():
    """A flight of 30 s, and what was kept of it."""
    flight = StandInFlight(steering=StandInSteering())
    history = FlightHistory(flight)
    for second in range(31):
        flight.seen.append(sight(float(second)))
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


def test_the_shared_scene_is_hidden_while_the_past_is_seen(page, flown):
    server, begun, shown = page._server, [], []

    def draw(scene, root, flight):
        begun.append(root)
        return [SimpleNamespace(show=lambda seen: shown.append(seen.time))]

    client = SimpleNamespace(
        client_id=0, scene=server.scene, gui=server.gui, atomic=server.atomic,
        camera=SimpleNamespace(aspect=1.2),
    )  # fmt: skip
    legend = SimpleNamespace(expand=lambda: begun.append("legend"), minimize=None)
    visitor = Visitor(client, WORLD, [], draw, legend)
    watched = {"aircraft": (flown[0], flown[0].sight)}
    visitor.seat._view.value = "free"
    for visitor.asked in (None, 7.0, 7.0, 20.5, None):
        looks_back = visitor.asked is not None
        visitor.seat._to_place = False
        visitor.show(watched, {"aircraft": flown})
        assert server.scene.get_handle_by_name(PAST_WORLD).visible is looks_back
        assert visitor.seat.world.visible is not looks_back
        assert set(visitor.past) == ({"aircraft"} if looks_back else set())
    assert begun == [f"{PAST_WORLD}/aircraft"]
    for width in (500.0, 900.0, 950.0):  # the legend is unfolded once there is room
        visitor.told_width(width)
    assert begun[1:] == ["legend"]
    assert shown == [7.0, 20.0]  # once each: what stands is not sent again
