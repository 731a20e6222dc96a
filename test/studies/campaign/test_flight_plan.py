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

from campaign_files import SHORT, short_campaign

from uav_tracking_mpc.studies.campaign.flight_plan import planned

TRUTH = {
    "told.response": 1.0,
    "uav_simulator.velocity_noise": 0.0,
    "target_publisher.motion": "stationary",
}


def plans(campaign):
    return [planned(campaign, number) for number in range(campaign.total)]


def test_groups_follow_one_another_and_errors_take_turns(tmp_path):
    flights = plans(short_campaign(tmp_path))
    assert [flight.group for flight in flights] == ["single"] * 3 + ["together"] * 3
    single = [flight.error for flight in flights[:3]]
    assert single == ["lag", "sensors", "driving"]
    assert {flight.error for flight in flights[3:]} == {"lag+sensors+driving"}


def test_one_error_leaves_all_else_right(tmp_path):
    for flight in plans(short_campaign(tmp_path))[:2]:
        others = {key: flight.values[key] for key in TRUTH}
        others.pop("told.response" if flight.error == "lag" else "uav_simulator.velocity_noise")
        assert others == {key: TRUTH[key] for key in others}


def test_a_share_of_the_range_keeps_within_it(tmp_path):
    flights = plans(short_campaign(tmp_path, flights=60))[30:]
    told = [flight.values["told.response"] for flight in flights]
    assert 0.5 <= min(told) < max(told) <= 2.0
    assert max(flight.values["uav_simulator.velocity_noise"] for flight in flights) <= 0.15
    motions = {flight.values["target_publisher.motion"] for flight in flights}
    assert motions == {"stationary", "circle", "line"}


def test_values_are_what_is_flown(tmp_path):
    flight = plans(short_campaign(tmp_path))[0]
    configuration = flight.configuration("l1")
    told = [flight.values["told.response"] * lag for lag in configuration.simulator.rate_lag]
    assert list(configuration.controller.rate_lag) == told
    assert configuration.controller.law == "l1"
    assert configuration.mission.duration == 8.0


def test_a_key_is_drawn_from_a_stream_of_its_own(tmp_path):
    """More flights, more keys or other laws leave what a flight meets as it was."""
    before = planned(short_campaign(tmp_path), 2)
    draw = {"uav_simulator.initial_speed": {"uniform": [20.0, 24.0]}, **SHORT["draw"]}
    after = planned(short_campaign(tmp_path, draw=draw, laws=["vector_field"]), 2)
    assert {key: after.values[key] for key in before.values} == before.values
    assert after.sections["uav_simulator"]["seed"] == before.sections["uav_simulator"]["seed"]


def test_seeds_differ(tmp_path):
    flights = plans(short_campaign(tmp_path))
    seeds = {flight.sections["uav_simulator"]["seed"] for flight in flights}
    seeds |= {flight.sections["target_publisher"]["seed"] for flight in flights}
    assert len(seeds) == 12
    assert planned(short_campaign(tmp_path, seed=4), 0).values != flights[0].values


def test_a_sweep_flies_all_combinations_of_the_same_draws(tmp_path):
    draw = {
        **SHORT["draw"],
        "nmpc_controller.range": {"grid": [250.0, 350.0, 3]},
        "target_publisher.rate": {"values": [5.0, 10.0]},
    }
    campaign = short_campaign(tmp_path, draw=draw, flights=2, errors=None, groups=None)
    flights = plans(campaign)
    assert len(flights) == 12
    points = [
        (flight.values["nmpc_controller.range"], flight.values["target_publisher.rate"])
        for flight in flights
    ]
    assert len(set(points)) == 6
    assert points[0] == points[1]
    assert len({flight.values["wind.speed"] for flight in flights}) == 2
