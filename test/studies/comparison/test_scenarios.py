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

"""Laws and mismatches by name: what is told, what is flown; failing sensors flown in short."""

import dataclasses
import math

import numpy as np
import pytest

from uav_tracking_mpc.parameters.specification import ParameterError
from uav_tracking_mpc.settings.configuration import load_configuration
from uav_tracking_mpc.simulation.closed_loop import ClosedLoop, simulate
from uav_tracking_mpc.simulation.motions import motion_of
from uav_tracking_mpc.studies.comparison.results import compare, prepared
from uav_tracking_mpc.studies.comparison.scenarios import (
    BEGIN,
    MISMATCHES,
    mismatched,
    settled_after,
    variants,
)


def configuration(scenario, *overrides):
    return load_configuration("small_uav", ["mission.duration=4", *overrides], scenario)


@pytest.mark.parametrize(
    ("heading", "wind", "direction"),
    [
        (3.0, 0.0, "counter_clockwise"),
        (-3.0, 0.0, "clockwise"),
        (3.14159, 3.0, "counter_clockwise"),
        (3.14159, -3.0, "clockwise"),
    ],
)
def test_the_nearest_direction_is_that_of_the_relative_motion_at_the_start(
    heading, wind, direction
):
    """From 600 m east: who moves north, seen from the target, goes counter-clockwise."""
    start = f"uav_simulator.initial_heading={heading}", f"uav_simulator.wind=[0, {wind}, 0]"
    assert prepared(configuration("still", *start), "nmpc").controller.direction == direction
    asked = configuration("still", *start, "nmpc_controller.direction=counter_clockwise")
    assert prepared(asked, "nmpc").controller.direction == "counter_clockwise"


def test_flights_do_not_depend_on_processes():
    scenarios = {name: configuration(name) for name in ("gusts", "noisy_target")}
    laws = ["l1", "vector_field"]
    alone, together = (compare(scenarios, laws, workers, show=False) for workers in (1, 2))
    assert len(alone) == len(together) == 2
    for one, other in zip(alone, together, strict=True):
        for law in laws:
            np.testing.assert_array_equal(one.logs[law].vehicle, other.logs[law].vehicle)
    assert not np.array_equal(alone[0].logs["l1"].vehicle, alone[0].logs["vector_field"].vehicle)


def test_all_laws_meet_the_same_start():
    logs = [simulate(prepared(configuration("wind"), law)) for law in ("nmpc", "l1")]
    np.testing.assert_array_equal(logs[0].vehicle[0], logs[1].vehicle[0])
    assert logs[0].orbit == logs[1].orbit
    assert (logs[0].solver, logs[1].solver) == ("newton", "none")


BASE = load_configuration("small_uav", scenario="crosswind")
SHARES = [name for name in MISMATCHES if name.startswith("lag_")]


@pytest.mark.parametrize("name", SHARES)
def test_the_controller_is_told_so_many_times_the_lag_and_the_aircraft_stays(name):
    flown, share = mismatched("small_uav", name), float(name.removeprefix("lag_"))
    assert flown.simulator == BASE.simulator
    for channel in ("rate_lag", "dead_time"):
        true, told = getattr(flown.simulator, channel), getattr(flown.controller, channel)
        assert told == pytest.approx([share * time for time in true])


def test_the_share_is_that_of_the_aircraft_that_is_flown():
    overrides = ("uav_simulator.rate_lag=[0.5, 0.2, 0.2]", "nmpc_controller.rate_lag=[1, 1, 1]")
    told = mismatched("small_uav", "lag_0.5", overrides).controller
    assert told.rate_lag == pytest.approx((0.25, 0.1, 0.1))


@pytest.mark.parametrize("name", [name for name in MISMATCHES if "lag" not in name])
def test_what_else_is_wrong_the_controller_is_not_told(name):
    flown = mismatched("small_uav", name)
    if name not in ("tight_gale", "second_order_roll"):
        assert flown.controller == BASE.controller
    before = BASE.simulator, BASE.target, BASE.changes
    assert (flown.simulator, flown.target, flown.changes) != before
    assert flown.mission.duration == 300.0
    several = variants(flown, name)
    for flight in several:
        times = [time for time, _ in flight.changes]
        assert times == sorted(times)
    if name.startswith("position") and len(several) > 1:
        assert several[0].changes != several[1].changes


@pytest.mark.parametrize(
    ("name", "section", "values"),
    [
        ("late_0.3", "simulator", {"state_delay": 0.3, "state_stamp_true": False}),
        ("stamped_0.3", "simulator", {"state_delay": 0.3, "state_stamp_true": True}),
        ("noise_2", "target", {"noise": 2.0, "rate": 5.0}),
        ("turn_rate_bias_2", "simulator", {"turn_rate_bias": math.radians(2.0)}),
        ("tight_gale", "simulator", {"wind": (-12.0, 0.0, 0.0)}),
        ("tight_gale", "controller", {"range": 180.0}),
        # The roll is told as the lag of the same time.
        ("second_order_roll", "simulator", {"roll_frequency": 3.0, "roll_damping": 0.6}),
        ("second_order_roll", "controller", {"rate_lag": pytest.approx((0.4, 0.13, 0.16))}),
    ],
)
def test_numbers_of_the_names(name, section, values):
    flown = getattr(mismatched("small_uav", name), section)
    assert {each: getattr(flown, each) for each in values} == values


def test_a_zigzag_turns_after_20_s():
    zigzag = motion_of(mismatched("small_uav", "zigzag").target)
    assert list(zigzag.velocity(19.0)) == pytest.approx([5.0, 0.0, 0.0])
    assert list(zigzag.velocity(21.0)) == pytest.approx([0.0, 5.0, 0.0])


@pytest.mark.parametrize(
    ("duration", "counts", "begin"), [(300, 90.0, 120.0), (20, 6.0, 8.0), (600, 90.0, 120.0)]
)
def test_a_shorter_flight_counts_and_changes_earlier(duration, counts, begin):
    flown = mismatched("small_uav", "delay_200", (f"mission.duration={duration}",))
    assert settled_after(flown) == pytest.approx(counts)
    assert flown.changes == ((pytest.approx(begin), "uav_simulator.command_delay=0.2"),)
    assert flown.simulator.command_delay == 0.0


def test_no_other_name_is_a_mismatch():
    with pytest.raises(ParameterError, match="mismatch is 'lag_9', must be one of lag_0, lag_0.25"):
        mismatched("small_uav", "lag_9")


def test_in_gusts_the_response_is_told_wrong_likewise():
    still, gusty = mismatched("small_uav", "lag_2"), mismatched("small_uav", "gust_lag_2")
    assert gusty.controller == still.controller
    assert gusty.simulator == mismatched("small_uav", "gust_moderate").simulator


def test_where_there_is_chance_five_seeds_fly_and_of_weaving_three_periods():
    def of(name):
        return variants(mismatched("small_uav", name), name)

    assert [each.simulator.seed for each in of("gust_lag_0")] == [0, 1, 2, 3, 4]
    assert [each.target.weave_period for each in of("weaving_target")] == [4.0, 8.0, 12.0]
    (late,) = of("delay_100")
    assert late.changes
    assert variants(BASE, "crosswind") == [BASE]


SOONER = 95.0  # s
SAID = {
    "airspeed_plus_3": [("airspeed", "stuck")],
    "airspeed_zero": [("airspeed", "off")],
    "heading_30": [("heading", "jumped")],
    "velocity_flip": [("ground velocity", "off"), ("ground velocity", "used")],
    "position_frozen": [("position", "stuck"), ("position", "used")],
    "position_silent": [("position", "silent"), ("position", "used")],
    "wind_turns": [],
    "airspeed_at_26": None,  # from the start on, off or stuck
}


# What test_failing_sensors.py has in the same way.
ALSO = ("airspeed_zero", "heading_30", "position_silent")


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.long] * (name in ALSO)) for name in SAID]
)
def test_a_failing_sensor_is_named_and_the_orbit_is_held(name):
    """Faults begin sooner, from a start near the orbit; a wind that turns blames no sensor."""
    near = (
        "uav_simulator.initial_position=[300.0, 0.0, 120.0]",
        "uav_simulator.initial_heading=1.5707963267948966",
    )
    case = prepared(variants(mismatched("small_uav", name, near), name)[0], "nmpc")
    changes = tuple((time - SOONER, change) for time, change in case.changes)
    loop = ClosedLoop(dataclasses.replace(case, changes=changes))
    until = BEGIN - SOONER + (70.0 if name == "wind_turns" else 25.0)
    airspeeds = []
    while loop.time < until:
        airspeeds.append(loop.tick().truth.airspeed)
    log = loop.log(until)
    said = [(news.sensor, news.state) for news in log.sensors]
    assert said == SAID[name] or (SAID[name] is None and said[0] in OFF_OR_STUCK)
    assert np.abs(log.error[log.time > until - 15.0, 0]).max() < 0.3
    assert min(airspeeds) > 20.0
    off = 0.5 if name == "airspeed_at_26" else 1.5
    assert np.abs(np.array(airspeeds[-200:]) - 22.0).max() < off


OFF_OR_STUCK = [("airspeed", "off"), ("airspeed", "stuck")]
