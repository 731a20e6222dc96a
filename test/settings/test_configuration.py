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

import re

import pytest
import yaml

from uav_tracking_mpc.parameters.specification import ParameterError, specifications
from uav_tracking_mpc.settings.configuration import (
    SECTIONS,
    configuration_names,
    load_configuration,
    scenario_names,
)

# What files of 0.2 may hold.
OF_0_2 = """
mission: duration plant speed
nmpc_controller: acceleration_max acceleration_min airspeed airspeed_max airspeed_min altitude
  autostart bank_max certificate control_rate dead_time direction distance_min fence_centre
  fence_radius force_max force_min height_min horizon horizon_step input_weights law
  limit_penalty limits model offset_weights path_angle_max path_angle_min pitch_rate_max
  plan_age_max range rate_lag record scheme solve_time_max solver state_timeout state_weights
  target_agility target_noise target_timeout terminal_constraint terminal_penalty
  terminal_scaling vehicle_model yaw_rate_max
target_publisher: delay drive_time dropout heading jump_offset jump_time motion noise position
  radius rate seed speed stand_time waypoints
uav_simulator: acceleration_max acceleration_min airspeed_noise attitude_noise bank_max
  dead_time gust_intensity initial_heading initial_path_angle initial_position initial_speed
  pitch_rate_max plant position_noise publish_clock rate_lag seed speed speed_max speed_min
  start_on_command state_rate velocity_noise wait_for_subscribers wind yaw_rate_max
"""


@pytest.mark.parametrize("section", re.findall(r"^(\w+):", OF_0_2, re.MULTILINE))
def test_parameters_of_0_2_have_their_names(section):
    names = re.search(rf"^{section}: ([\w\s]*?)(?=^\w+:|\Z)", OF_0_2, re.MULTILINE)[1].split()
    assert {*names} <= {item.name for item in specifications(SECTIONS[section])}
    assert len(names) >= 3


@pytest.mark.parametrize("name", configuration_names())
def test_every_configuration_that_comes_along_is_allowed(name):
    assert load_configuration(name).name == name


def test_paper_is_table_1(paper_start):
    from uav_tracking_mpc.dynamics.relative import relative_state

    paper = load_configuration("paper")
    assert (paper.controller.range, paper.controller.altitude) == (150.0, 50.0)
    assert (paper.controller.airspeed, paper.controller.horizon) == (4.0, 10)
    assert paper.mission.duration == 150.0
    start = relative_state(paper.simulator.initial_state, paper.target.position)
    assert start == pytest.approx(paper_start)


def test_the_controller_of_small_uav_knows_its_aircraft():
    """Lag, dead time and limits are those of the simulated one; its start and orbit are flyable."""
    small = load_configuration("small_uav")
    controller, simulator = small.controller, small.simulator
    for name in (
        "rate_lag", "dead_time", "bank_max", "yaw_rate_max", "pitch_rate_max", "acceleration_min",
        "acceleration_max",
    ):  # fmt: skip
        assert getattr(controller, name) == getattr(simulator, name)
    assert simulator.speed_min <= controller.airspeed_min
    assert controller.airspeed_max <= simulator.speed_max
    assert controller.terminal_constraint == "artificial_orbit"
    x, y, z = simulator.initial_position
    assert (x * x + y * y + z * z) ** 0.5 == pytest.approx(600.0)
    assert controller.envelope.refusal(controller.orbit, [10.0, 5.0, 0.0]) == ""


@pytest.mark.parametrize(
    "overrides",
    [
        ["uav_simulator.wind=[8.0, 0.0, 0.0]", "uav_simulator.gust_intensity=1.5"],
        ["target_publisher.motion=line", "target_publisher.speed=6.0"],
        ["target_publisher.motion=circle", "target_publisher.dropout=0.3"],
        ["uav_simulator.position_noise=1.0", "nmpc_controller.fence_radius=2000.0"],
    ],
)
def test_small_uav_is_the_base_of_flights_in_wind_after_moving_targets(overrides):
    assert load_configuration("small_uav", overrides).mission.plant == "vehicle"


def test_a_change_of_a_section_is_checked_and_in_the_file():
    base = load_configuration("small_uav", scenario="crosswind")
    flown = base.changed("autopilot_link", {"connection": "udpin:127.0.0.1:1"})
    assert (flown.link.connection, base.link.connection) == ("udpin:127.0.0.1:1", "")
    assert "connection: udpin:127.0.0.1:1" in flown.yaml()
    assert (flown.controller, flown.scenario) == (base.controller, base.scenario)
    with pytest.raises(ParameterError, match="'nmpc_controller': parameter 'range' is -1.0"):
        base.changed("nmpc_controller", {"range": -1.0})


def test_yaml_is_a_ros_parameter_file_that_loads_again(tmp_path):
    configuration = load_configuration("paper", ["target_publisher.rate=7.0"])
    file = tmp_path / "again.yaml"
    file.write_text(configuration.yaml())
    document = yaml.safe_load(file.read_text())
    assert document["/**/target_publisher"]["ros__parameters"]["rate"] == 7.0
    again = load_configuration(str(file))
    assert again.controller == configuration.controller
    assert again.target == configuration.target


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[1, 2", "cannot be read"),
        ("just text", "holds no sections"),
        ("pilot: {ros__parameters: {}}", "section 'pilot' is unknown"),
        ("nmpc_controller: {range: 1}", "has no ros__parameters"),
        ("nmpc_controller: {ros__parameters: {rnage: 1.0}}", "'rnage' is unknown"),
        ("/**/nmpc_controller: {ros__parameters: {range: far}}", "'nmpc_controller': .*far"),
        ("a: !!python/object/apply:os.system ['true']", "cannot be read"),
        ("a: 2020-13-45", "cannot be read"),
        (
            "a: 1\nb: 2\na: 3",
            "bad.yaml cannot be read: 'a' is given twice, in line 1 and in line 3",
        ),
        ("nmpc_controller: {ros__parameters: {1: 2}}", "1 is no name of a parameter"),
    ],
)
def test_bad_files_are_refused_with_the_reason(tmp_path, text, message):
    file = tmp_path / "bad.yaml"
    file.write_text(text)
    with pytest.raises(ParameterError, match=message):
        load_configuration(str(file))


@pytest.mark.parametrize("name", ["nowhere", "../paper", "paper.yaml", ""])
def test_unknown_configuration_lists_the_known(name):
    with pytest.raises(ParameterError, match="must be a file or one of .*paper"):
        load_configuration(name)


@pytest.mark.parametrize(
    "override", ["range=1", "nmpc_controller.range", "pilot.range=1", "nmpc_controller.=1"]
)
def test_bad_overrides_say_what_they_must_be(override):
    with pytest.raises(ParameterError, match="SECTION.PARAMETER=VALUE"):
        load_configuration("paper", [override])


@pytest.mark.parametrize("value", ["2020-13-45", "!!float abc", "!!binary x", "9" * 5000])
def test_an_override_that_cannot_be_read_is_named(value):
    with pytest.raises(ParameterError, match="range"):
        load_configuration("paper", [f"nmpc_controller.range={value}"])


@pytest.mark.parametrize(
    ("text", "value"), [("1.6e2", 160.0), ("1e3", 1000.0), ("2E+2", 200.0), ("150", 150.0)]
)
def test_numbers_may_have_exponents(text, value):
    override = f"nmpc_controller.range={text}"
    assert load_configuration("paper", [override]).controller.range == value


@pytest.mark.parametrize("text", ["2:30", "0x96", "1_000", "9" * 400])
def test_what_only_looks_like_a_number_is_refused(text):
    with pytest.raises(ParameterError, match="'range' is"):
        load_configuration("paper", [f"nmpc_controller.range={text}"])


@pytest.mark.parametrize("name", scenario_names())
def test_every_scenario_that_comes_along_says_what_it_is(name):
    scenario = load_configuration("small_uav", scenario=name).scenario
    assert scenario.title
    assert scenario.description.endswith(".")


def test_a_scenario_replaces_what_it_names_and_overrides_win():
    plain = load_configuration("small_uav")
    tight = load_configuration(
        "small_uav", ["uav_simulator.wind=[-9, 0, 0]"], scenario="tight_headwind"
    )
    assert tight.name == "small_uav"
    assert (tight.controller.range, tight.target.motion) == (180.0, "line")
    assert tight.simulator.wind == (-9.0, 0.0, 0.0)
    assert tight.controller.state_weights == plain.controller.state_weights
    assert plain.scenario is None
    assert "/**/scenario" not in tight.yaml()


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("scenario: {ros__parameters: {name: x}}", "section 'scenario': parameter 'name'"),
        ("weather: {ros__parameters: {}}", "'weather' is unknown, known are: .*scenario"),
    ],
)
def test_bad_scenarios_are_refused_with_the_reason(tmp_path, text, message):
    file = tmp_path / "bad.yaml"
    file.write_text(text)
    with pytest.raises(ParameterError, match=message):
        load_configuration("small_uav", scenario=str(file))
    with pytest.raises(
        ParameterError, match="scenario is 'storm', must be a file or one of .*wind"
    ):
        load_configuration("small_uav", scenario="storm")
