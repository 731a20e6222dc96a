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

"""A mission as a file: what was saved is flown again."""

import html
import re
from urllib.parse import parse_qs, urlsplit

from processes import wait_for
from watched_flight_stand_in import StandInClient, StandInFlight, StandInSource, StandInSteering

from uav_tracking_mpc.settings.configuration import load_configuration
from uav_tracking_mpc.view.panel import PANEL_PART
from uav_tracking_mpc.view.panel.mission_file import (
    MissionFile,
    fly_and_tell,
    fly_mission,
    mission_of,
)
from uav_tracking_mpc.view.watched_flight import CONTROLLER, SIMULATOR, TARGET


def steered():
    steering = StandInSteering()
    steering.values[SIMULATOR]["wind"] = (3.0, -4.0, 0.0)
    steering.values[TARGET] |= {"motion": "circle", "speed": 5.0, "radius": 80.0}
    steering.values[CONTROLLER] |= {"range": 350.0, "direction": "clockwise"}
    return steering


def test_it_is_a_scenario_file(tmp_path):
    path = tmp_path / "mission.yaml"
    path.write_text(mission_of(steered(), "small_uav"))
    configuration = load_configuration("small_uav", scenario=str(path))
    assert configuration.scenario.title == "small_uav"
    assert configuration.simulator.wind == (3.0, -4.0, 0.0)
    assert (configuration.target.motion, configuration.target.speed) == ("circle", 5.0)
    assert (configuration.controller.range, configuration.controller.direction) == (
        350.0,
        "clockwise",
    )


def test_it_is_flown_again():
    other = StandInSteering()
    assert fly_mission(other, mission_of(steered(), "one").encode()) == ""
    changes = {node: values for _, node, values in other.asked}
    assert list(changes) == [TARGET, SIMULATOR, CONTROLLER]
    assert list(changes[SIMULATOR]["wind"]) == [3.0, -4.0, 0.0]
    assert changes[TARGET]["radius"] == 80.0
    assert changes[CONTROLLER]["range"] == 350.0
    assert "speed" not in changes[SIMULATOR]  # how fast time goes is no part of a mission


def test_what_is_no_mission_or_is_refused_is_told():
    steering = StandInSteering()
    assert "section 'nonsense' is unknown" in fly_mission(steering, b"nonsense: {}")
    assert "/tmp" not in fly_mission(steering, b"{{{")
    assert fly_mission(steering, b"\xff\xfe")
    for content, words in (
        (b"/**/uav_simulator: {ros__parameters: {1: 2}}", "1 is no name of a parameter"),
        (b"/**/uav_simulator: {ros__parameters: {wind: 2020-13-45}}", "cannot be read"),
        (b"/**/mission: {ros__parameters: {duration: 5}}", "it says nothing of nmpc_controller"),
    ):
        assert words in fly_mission(steering, content)
    assert steering.asked == []
    steering.refusal = "the wind is too strong"
    assert "the wind is too strong" in fly_mission(steering, mission_of(steered(), "a").encode())


def test_what_is_flown_although_something_is_refused_is_told():
    steering = StandInSteering()
    change = steering.change
    steering.change = lambda node, **values: (
        "the orbit is too small" if node == CONTROLLER else change(node, **values)
    )
    refusal = fly_mission(steering, mission_of(steered(), "one").encode())
    assert refusal == (
        "the orbit is too small; what it says of target_publisher and uav_simulator is flown"
    )
    assert tuple(steering.values[SIMULATOR]["wind"]) == (3.0, -4.0, 0.0)


def test_the_page_is_told_what_a_node_raises():
    steering, client = StandInSteering(), StandInClient()
    steering.failure = RuntimeError("the plant is gone")
    fly_and_tell(client, steering, mission_of(steered(), "one").encode())
    assert wait_for(lambda: client.notifications)
    ((title, words),) = client.notifications
    assert "is refused" in title and words == "RuntimeError: the plant is gone"


def test_a_link_holds_it_and_no_token(panel, flight):
    shown = panel(MissionFile)
    shown.by_hand("Make a link", True)
    shown.until(lambda: "href" in shown.text)
    link = urlsplit(html.unescape(re.search('href="([^"]*)"', shown.text)[1]))
    assert (link.path, link.query) == ("/", "")
    (mission,) = parse_qs(link.fragment)["mission"]
    assert mission == mission_of(flight.steering, flight.name)


def test_it_is_absent_where_nothing_is_steered():
    assert PANEL_PART.own()["mission_file"] is MissionFile  # where something is
    flight = StandInFlight()
    assert not MissionFile.fits(flight, StandInSource(flight))
