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

import pytest

from uav_tracking_mpc.parameters.specification import ParameterError
from uav_tracking_mpc.settings.configuration import load_configuration
from uav_tracking_mpc.studies.campaign.uncertain_inputs import DERIVED, check_value, read, write


def sections():
    return load_configuration("small_uav", ["target_publisher.position=[100, 50, 3]"]).sections


def after(**values):
    content = sections()
    write(content, {key.replace("__", "."): value for key, value in values.items()})
    return content


def test_parameters_components_and_degrees():
    content = sections()
    write(
        content,
        {
            "uav_simulator.heading_bias_deg": 90.0,
            "uav_simulator.rate_lag[2]": 0.9,
            "uav_simulator.command_gain": 1.2,
            "target_publisher.motion": "line",
        },
    )
    simulator = content["uav_simulator"]
    assert simulator["heading_bias"] == pytest.approx(0.5 * math.pi)
    assert simulator["rate_lag"] == [0.3, 0.13, 0.9]
    assert simulator["command_gain"] == [1.2, 1.2, 1.2]
    assert content["target_publisher"]["motion"] == "line"
    assert read(content, "uav_simulator.heading_bias_deg") == pytest.approx(90.0)
    assert read(content, "uav_simulator.rate_lag[2]") == 0.9


def test_a_start_is_seen_from_the_target():
    content = sections()
    write(content, {"start.azimuth_deg": 90.0, "start.distance": 400.0, "start.height": 80.0})
    assert content["uav_simulator"]["initial_position"] == pytest.approx([100.0, 450.0, 83.0])
    assert read(content, "start.distance") == pytest.approx(400.0)


def test_a_start_is_seen_from_where_a_circling_target_begins():
    content = sections()
    write(
        content,
        {
            "target_publisher.motion": "circle",
            "target_publisher.radius": 20.0,
            "target_publisher.heading_deg": 180.0,
            "start.azimuth_deg": 0.0,
            "start.distance": 300.0,
        },
    )
    assert content["uav_simulator"]["initial_position"][:2] == pytest.approx([380.0, 50.0])


def test_wind_by_speed_and_direction():
    content = after(wind__direction_deg=-90.0, wind__speed=7.0)
    assert content["uav_simulator"]["wind"] == pytest.approx([0.0, -7.0, 0.0], abs=1e-12)
    assert read(content, "wind.direction_deg") == pytest.approx(-90.0)


def test_what_is_told_is_a_share_of_the_truth():
    content = after(told__response=0.5, true__lag=2.0)
    assert content["uav_simulator"]["rate_lag"] == pytest.approx([0.6, 0.26, 0.32])
    assert content["nmpc_controller"]["rate_lag"] == pytest.approx([0.3, 0.13, 0.16])
    assert content["nmpc_controller"]["dead_time"] == pytest.approx([0.085, 0.1, 0.05])


@pytest.mark.parametrize("key", DERIVED)
def test_what_is_derived_can_be_read_again(key):
    content = sections()
    value = 1.0 if key.startswith(("told", "true")) else 3.0
    write(content, {"wind.speed": 2.0, "velocity_bias.speed": 2.0})
    write(content, {key: value})
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
