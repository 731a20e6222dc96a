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

import pytest
from campaign_files import SHORT, short_campaign, written

from uav_tracking_mpc.parameters.specification import ParameterError
from uav_tracking_mpc.settings.configuration import campaign_names
from uav_tracking_mpc.studies.campaign.campaign_file import load_campaign
from uav_tracking_mpc.studies.campaign.flight_plan import check_flights


def test_a_file_is_taken_as_it_stands(tmp_path):
    campaign = short_campaign(tmp_path)
    assert (campaign.name, campaign.flights, campaign.laws) == ("short", 6, ("l1",))
    assert campaign.inputs == [
        "start.distance",
        "wind.speed",
        "wind.direction_deg",
        "told.response",
        "uav_simulator.velocity_noise",
        "target_publisher.motion",
    ]
    assert campaign.words == {"target_publisher.motion"}
    assert campaign.failure.names == ("orbit_lost", "never_settled")
    assert campaign.failure.beyond == 40.0


def test_nothing_but_draws_is_a_campaign(tmp_path):
    path = tmp_path / "plain.yaml"
    path.write_text("draw: {wind.speed: {uniform: [0, 5]}}\n")
    campaign = load_campaign(str(path))
    assert campaign.base.name == "small_uav"
    assert campaign.laws == ("nmpc",)
    assert [group.errors for group in campaign.groups] == ["none"]


def test_the_command_line_wins(tmp_path):
    path = str(written(tmp_path))
    sets = ("wind.speed=3.0", "start.distance={uniform: [200, 210]}")
    campaign = load_campaign(path, sets, ("vector_field",), 4)
    assert campaign.draw["wind.speed"].arguments == (3.0,)
    assert campaign.draw["start.distance"].arguments == (200.0, 210.0)
    assert (campaign.laws, campaign.flights) == (("vector_field",), 4)


def test_what_decides_the_outcome_changes_the_identity(tmp_path):
    campaign = short_campaign(tmp_path)
    assert short_campaign(tmp_path, title="other words").identity == campaign.identity
    for changes in ({"seed": 4}, {"laws": ["vector_field"]}, {"settled_after": 5.0}):
        assert short_campaign(tmp_path, **changes).identity != campaign.identity


@pytest.mark.parametrize("name", campaign_names())
def test_those_of_the_package_can_be_flown(name):
    campaign = load_campaign(name, flights=60)
    check_flights(campaign, range(campaign.total))


def test_the_package_has_the_campaign_of_2000_flights():
    campaign = load_campaign("robustness")
    assert campaign.total == 2000
    assert [group.share for group in campaign.groups] == [0.5, 0.5]


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"speed": 3}, "'speed' is unknown, known are: title"),
        ({"flights": 0}, "'flights' is 0, must be an integer of at least 1"),
        ({"seed": -1}, "'seed' is -1"),
        ({"laws": "nmpc"}, "'laws' is 'nmpc', must be a list"),
        ({"draw": [1]}, "draw is [1], must hold names and values"),
        ({"draw": {"wind.sped": 1.0}}, "'wind.sped' must be"),
        ({"draw": {"uav_simulator.gust_intensity": {"uniform": [0, 90]}}}, "may become 90.0"),
        ({"errors": {"x": {"wind.speed": {"values": [1, 2]}}}}, "only what is under 'draw'"),
        ({"groups": {"a": {"share": 0.4}}}, "add up to 0.4, must be 1"),
        ({"groups": {"a": {"errors": "some"}}}, "'errors' is 'some'"),
        ({"groups": {"a": {"range": 2.0}}}, "'range' is 2.0, must be a number from 0 to 1"),
        ({"failure": {"crash": {}}}, "'crash' is unknown"),
        ({"failure": {"orbit_lost": {"by": 3.0}}}, "has no 'by'"),
        ({"failure": {"limit_passed": {"limits": ["bang"]}}}, "'limits' is ['bang']"),
        ({"failure": {"orbit_lost": {"beyond": -3.0}}}, "must be a positive number"),
        ({"config": "mars"}, "configuration is 'mars'"),
    ],
)
def test_mistakes_are_explained(tmp_path, changes, words):
    with pytest.raises(ParameterError) as refused:
        short_campaign(tmp_path, **changes)
    assert words in str(refused.value)


def test_a_name_that_nobody_knows_is_refused():
    with pytest.raises(ParameterError, match="campaign is 'storm', must be a file or one of"):
        load_campaign("storm")


def test_flights_that_cannot_be_flown_are_found_before_any_flies(tmp_path):
    draw = {**SHORT["draw"], "uav_simulator.initial_speed": {"uniform": [5.0, 30.0]}}
    campaign = short_campaign(
        tmp_path, draw=draw, flights=40
    )  # each value may be, but not below speed_min
    with pytest.raises(ParameterError, match=r"flight \d+: .*'initial_speed'"):
        check_flights(campaign, range(campaign.total))
    with pytest.raises(ParameterError, match="'settled_after' is 9 s, flight 0 ends after 8 s"):
        check_flights(short_campaign(tmp_path, settled_after=9.0), range(6))
