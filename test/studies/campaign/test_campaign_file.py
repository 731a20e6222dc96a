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


import math
from dataclasses import replace

import numpy as np
import pytest
from campaign_files import SHORT, short_campaign, written
from example_flights import orbiting
from scipy import stats

from uav_tracking_mpc.parameters.specification import ParameterError
from uav_tracking_mpc.settings.configuration import campaign_names, load_configuration
from uav_tracking_mpc.settings.tracking import TrackingParameters
from uav_tracking_mpc.studies.campaign.campaign_file import Criteria, Distribution, load_campaign
from uav_tracking_mpc.studies.campaign.campaign_run import check_flights
from uav_tracking_mpc.studies.campaign.uncertain_inputs import DERIVED, check_value, read, write


def drawn(written, count=2000, **within):
    draw, random = Distribution.of("key", written), np.random.default_rng(8)
    if within:
        return [draw.draw_within(random, **within) for _ in range(count)]
    return [draw.draw(random) for _ in range(count)]


@pytest.mark.parametrize(
    ("written", "distribution"),
    [
        ({"uniform": [2.0, 5.0]}, stats.uniform(2.0, 3.0)),
        ({"log_uniform": [0.1, 10.0]}, stats.loguniform(0.1, 10.0)),
        ({"normal": [1.0, 3.0]}, stats.norm(1.0, 3.0)),
    ],
)
def test_numbers_are_distributed_as_they_are_called(written, distribution):
    assert stats.kstest(drawn(written), distribution.cdf).pvalue > 0.01


def test_a_value_is_itself_and_a_choice_takes_all_alike():
    assert set(drawn(4.5, 3)) == {4.5}
    assert drawn([1.0, 2.0], 1) == [[1.0, 2.0]]
    values = drawn({"choice": ["a", True, 3]})
    assert {str(value) for value in values} == {"a", "True", "3"}
    assert abs(values.count("a") / len(values) - 1.0 / 3.0) < 0.05


def test_half_the_range_is_half_way_from_what_is_right():
    """Half of a choice is made in half of the flights; what is constant is not shared."""
    values = drawn({"uniform": [0.0, 3.0]}, neutral=1.0, share=0.5)
    assert 0.5 <= min(values) < 0.51
    assert 1.99 < max(values) <= 2.0
    chosen = drawn({"choice": ["zigzag"]}, neutral="line", share=0.5)
    assert abs(chosen.count("zigzag") / len(chosen) - 0.5) < 0.05
    assert set(chosen) == {"zigzag", "line"}
    assert set(drawn(5.0, 3, neutral=10.0, share=0.5)) == {5.0}


def test_a_grid_is_evenly_spaced():
    grid = Distribution.of("key", {"grid": [0.0, 1.0, 5]})
    assert grid.kind == "values"
    assert grid.arguments == (0.0, 0.25, 0.5, 0.75, 1.0)
    assert Distribution.of("key", {"values": [1, "b"]}).arguments == (1, "b")


@pytest.mark.parametrize(
    ("written", "words"),
    [
        ({"triangle": [0, 1]}, "must be a value or one of uniform, log_uniform"),
        ({"uniform": 3.0}, "with a list"),
        ({}, "must be a value or one of"),
        ({"uniform": [1.0]}, "must have 2 values"),
        ({"choice": []}, "must have at least one values"),
        ({"uniform": [1.0, 0.0]}, "in order"),
        ({"uniform": ["a", 0.0]}, "finite numbers"),
        ({"normal": [0.0, -1.0]}, "standard deviation"),
        ({"log_uniform": [0.0, 1.0]}, "positive"),
        ({"grid": [0.0, 1.0, 2.5]}, "how many"),
        ({"uniform": [0.0, float("inf")]}, "finite"),
    ],
)
def test_what_is_none_is_refused(written, words):
    with pytest.raises(ParameterError, match=words):
        Distribution.of("wind.speed", written)


LIMITS = TrackingParameters(airspeed_min=2.0, airspeed_max=8.0, bank_max=0.6)
CRITERIA = Criteria(beyond=30.0, settled_for=20.0)
TIME = np.arange(0.0, 100.0, 0.5)


def error(*pieces):
    """Range error that is so large from each time on."""
    values = np.zeros_like(TIME)
    for begin, size in pieces:
        values[begin <= TIME] = size
    return values


@pytest.mark.parametrize(
    ("flown", "settled"),
    [
        (error(), 20.0),
        (error((0.0, 90.0), (40.0, -12.0)), 60.0),
        (error((0.0, 90.0), (10.0, 0.0), (20.0, 90.0), (50.0, 3.0)), 70.0),  # passing through
        (error((0.0, 90.0)), None),
        (error((0.0, 90.0), (95.0, 0.0)), None),
        (np.full_like(TIME, np.nan), None),
    ],
)
def test_settled_is_inside_for_long_enough(flown, settled):
    assert CRITERIA.settled_at(TIME, flown) == settled


def test_settled_at_once_is_inside_for_a_sample():
    at_once = Criteria(beyond=30.0, settled_for=0.0)
    assert at_once.settled_at(TIME, error()) == 0.0
    assert at_once.settled_at(TIME, error((0.0, 90.0), (40.0, -12.0))) == 40.0
    assert at_once.settled_at(TIME, error((0.0, 90.0))) is None


@pytest.mark.parametrize(
    ("flown", "found"),
    [
        (error(), []),
        (error((0.0, 90.0)), ["never_settled"]),
        (error((60.0, 29.0)), []),
        (error((60.0, -31.0)), ["orbit_lost"]),
        (error((60.0, np.nan)), ["orbit_lost"]),
        (error((0.0, 90.0), (50.0, 0.0)), []),
    ],
)
def test_an_orbit_is_lost_after_settling(flown, found):
    log = orbiting(len(TIME), step=0.5)
    assert CRITERIA.failures(log, flown, LIMITS) == found
    assert replace(CRITERIA, names=("limit_passed",)).failures(log, flown, LIMITS) == []


@pytest.mark.parametrize(
    ("speed", "limits", "found"),
    [
        (8.3, ("airspeed",), []),
        (8.5, ("airspeed",), ["limit_passed:airspeed"]),
        (1.8, ("airspeed", "bank"), ["limit_passed:airspeed"]),
        (8.5, ("path_angle",), []),
    ],
)
def test_a_limit_may_be_passed_by_a_share(speed, limits, found):
    log = orbiting(200, step=0.5)
    log.vehicle[50, 5] = speed
    criteria = Criteria(("limit_passed",), by=0.05, limits=limits)
    assert criteria.failures(log, log.error[:, 0], LIMITS) == found


def sections():
    return load_configuration("small_uav", ["target_publisher.position=[100, 50, 3]"]).sections


def given(values):
    """The parameters of a flight with these inputs."""
    content = sections()
    write(content, values)
    return content


def test_parameters_components_and_degrees():
    content = given(
        {
            "uav_simulator.heading_bias_deg": 90.0,
            "uav_simulator.rate_lag[2]": 0.9,
            "uav_simulator.command_gain": 1.2,
            "target_publisher.motion": "line",
        }
    )
    simulator = content["uav_simulator"]
    assert simulator["heading_bias"] == pytest.approx(0.5 * math.pi)
    assert simulator["rate_lag"] == [0.3, 0.13, 0.9]
    assert simulator["command_gain"] == [1.2, 1.2, 1.2]
    assert content["target_publisher"]["motion"] == "line"
    assert read(content, "uav_simulator.heading_bias_deg") == pytest.approx(90.0)
    assert read(content, "uav_simulator.rate_lag[2]") == 0.9


def test_a_start_is_seen_from_the_target_and_wind_by_speed_and_direction():
    content = given(
        {
            "start.azimuth_deg": 90.0,
            "start.distance": 400.0,
            "start.height": 80.0,
            "wind.direction_deg": -90.0,
            "wind.speed": 7.0,
        }
    )
    simulator = content["uav_simulator"]
    assert simulator["initial_position"] == pytest.approx([100.0, 450.0, 83.0])
    assert simulator["wind"] == pytest.approx([0.0, -7.0, 0.0], abs=1e-12)
    circling = {
        "target_publisher.motion": "circle",
        "target_publisher.radius": 20.0,
        "target_publisher.heading_deg": 180.0,
        "start.azimuth_deg": 0.0,
        "start.distance": 300.0,
    }
    position = given(circling)["uav_simulator"]["initial_position"]
    assert position[:2] == pytest.approx([380.0, 50.0])  # where a circling target begins


def test_what_is_told_is_a_share_of_the_truth():
    content = given({"told.response": 0.5, "true.lag": 2.0})
    assert content["uav_simulator"]["rate_lag"] == pytest.approx([0.6, 0.26, 0.32])
    assert content["nmpc_controller"]["rate_lag"] == pytest.approx([0.3, 0.13, 0.16])
    assert content["nmpc_controller"]["dead_time"] == pytest.approx([0.085, 0.1, 0.05])


@pytest.mark.parametrize("key", DERIVED)
def test_what_is_derived_can_be_read_again(key):
    value = 1.0 if key.startswith(("told", "true")) else 3.0
    content = given({"wind.speed": 2.0, "velocity_bias.speed": 2.0, key: value})
    assert read(content, key) == pytest.approx(value)


@pytest.mark.parametrize(
    ("key", "words"),
    [
        ("wind.sped", "such as wind.speed"),
        ("uav_simulator.gust", "no such parameter; near are gust_intensity"),
        ("autopilot.gain", "SECTION one of nmpc_controller"),
        ("uav_simulator.wind[3]", "no component 3"),
        ("uav_simulator.gust_intensity[0]", "no component 0"),
        ("uav_simulator.gust_intensity_deg", "is no angle"),
    ],
)
def test_unknown_names_are_refused(key, words):
    with pytest.raises(ParameterError) as refused:
        read(sections(), key)
    assert words in str(refused.value)


def test_values_out_of_range_are_refused():
    check_value(sections(), "uav_simulator.wind[0]", 100.0)
    with pytest.raises(ParameterError, match=r"'uav_simulator.wind\[0\]' may become 120"):
        check_value(sections(), "uav_simulator.wind[0]", 120.0)
    with pytest.raises(ParameterError, match="must be a number"):
        check_value(sections(), "wind.speed", "strong")


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
    path.write_text("config:\ndraw: {wind.speed: {uniform: [0, 5]}}\n")
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
    campaign = load_campaign(name)
    few = replace(campaign, flights=24)
    check_flights(few, range(few.total))
    if name == "robustness":
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
        ({"draw": {1: 1.0}}, "'1' must be SECTION.PARAMETER"),
        ({"draw": {"uav_simulator.gust_intensity": {"uniform": [0, 90]}}}, "may become 90.0"),
        ({"errors": {"x": {"wind.speed": {"values": [1, 2]}}}}, "only what is under 'draw'"),
        ({"groups": {"a": {"share": 0.4}}}, "add up to 0.4, must be 1"),
        ({"groups": {"a": {"errors": "some"}}}, "'errors' is 'some'"),
        ({"groups": {"a": {"range": 2.0}}}, "'range' is 2.0, must be a number from 0 to 1"),
        (
            {
                "errors": {"lag": {"uav_simulator.rate_lag": {"uniform": [0.1, 0.2]}}},
                "groups": {"a": {"range": 0.5}},
            },
            "'uav_simulator.rate_lag' is a list",
        ),
        ({"failure": {"crash": {}}}, "'crash' is unknown"),
        ({"failure": {"orbit_lost": {"by": 3.0}}}, "has no 'by'"),
        ({"failure": {"limit_passed": {"limits": ["bang"]}}}, "'limits' is ['bang']"),
        ({"failure": {"orbit_lost": {"beyond": -3.0}}}, "must be a number of at least 0 m"),
        ({"config": "mars"}, "configuration is 'mars'"),
    ],
)
def test_mistakes_are_explained(tmp_path, changes, words):
    with pytest.raises(ParameterError, match="campaign is 'storm', must be a file or one of"):
        load_campaign("storm")
    with pytest.raises(ParameterError) as refused:
        short_campaign(tmp_path, **changes)
    assert words in str(refused.value)


def test_flights_that_cannot_be_flown_are_found_before_any_flies(tmp_path):
    draw = {**SHORT["draw"], "uav_simulator.initial_speed": {"uniform": [5.0, 30.0]}}
    campaign = short_campaign(
        tmp_path, draw=draw, flights=40
    )  # each value may be, but not below speed_min
    with pytest.raises(ParameterError, match=r"flight \d+: .*'initial_speed'"):
        check_flights(campaign, range(campaign.total))
    with pytest.raises(ParameterError, match="'settled_after' is 9 s, flight 0 ends after 6 s"):
        check_flights(short_campaign(tmp_path, settled_after=9.0), range(6))
