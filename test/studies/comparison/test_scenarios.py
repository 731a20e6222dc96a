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

import numpy as np
import pytest

from uav_tracking_mpc.parameters.specification import ParameterError
from uav_tracking_mpc.settings.configuration import load_configuration
from uav_tracking_mpc.simulation.closed_loop import simulate
from uav_tracking_mpc.simulation.motions import motion_of
from uav_tracking_mpc.studies.comparison.results import compare, prepared
from uav_tracking_mpc.studies.comparison.scenarios import (
    LAG_SHARES,
    MISMATCHES,
    mismatched,
    settled_after,
    variants,
)

SHORT = ["mission.duration=4"]


def configuration(scenario, *overrides):
    return load_configuration("small_uav", [*SHORT, *overrides], scenario)


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
    flown = configuration(
        "still", f"uav_simulator.initial_heading={heading}", f"uav_simulator.wind=[0, {wind}, 0]"
    )
    assert prepared(flown, "nmpc").controller.direction == direction


def test_a_direction_that_is_asked_for_stays():
    flown = configuration("still", "nmpc_controller.direction=counter_clockwise")
    assert prepared(flown, "nmpc").controller.direction == "counter_clockwise"


def test_flights_do_not_depend_on_processes():
    scenarios = {name: configuration(name) for name in ("gusts", "noisy_target")}
    laws = ["l1", "vector_field"]
    alone = compare(scenarios, laws, workers=1, show=False)
    together = compare(scenarios, laws, workers=2, show=False)
    assert len(alone) == len(together) == 2
    for scenario in (0, 1):
        for law in laws:
            one, other = alone[scenario].logs[law], together[scenario].logs[law]
            np.testing.assert_array_equal(one.vehicle, other.vehicle)
    assert not np.array_equal(alone[0].logs["l1"].vehicle, alone[0].logs["vector_field"].vehicle)


def test_all_laws_meet_the_same_start():
    logs = [simulate(prepared(configuration("wind"), law)) for law in ("nmpc", "l1")]
    np.testing.assert_array_equal(logs[0].vehicle[0], logs[1].vehicle[0])
    assert logs[0].orbit == logs[1].orbit
    assert (logs[0].solver, logs[1].solver) == ("newton", "none")


BASE = load_configuration("small_uav", scenario="crosswind")


@pytest.mark.parametrize("share", LAG_SHARES)
def test_the_controller_is_told_so_many_times_the_lag_and_the_aircraft_stays(share):
    flown = mismatched("small_uav", f"lag_{share:g}")
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


def test_numbers_of_the_names():
    late = mismatched("small_uav", "late_0.3").simulator
    assert (late.state_delay, late.state_stamp_true) == (0.3, False)
    assert mismatched("small_uav", "stamped_0.3").simulator.state_stamp_true
    noise = mismatched("small_uav", "noise_2").target
    assert (noise.noise, noise.rate) == (2.0, 5.0)
    turn_rate = mismatched("small_uav", "turn_rate_bias_2").simulator.turn_rate_bias
    assert turn_rate == pytest.approx(math.radians(2.0))
    gale = mismatched("small_uav", "tight_gale")
    drift = gale.simulator.wind[0] - motion_of(gale.target).velocity(0.0)[0]
    assert (drift, gale.controller.range) == (-17.0, 180.0)
    zigzag = motion_of(mismatched("small_uav", "zigzag").target)
    assert list(zigzag.velocity(19.0)) == pytest.approx([5.0, 0.0, 0.0])
    assert list(zigzag.velocity(21.0)) == pytest.approx([0.0, 5.0, 0.0])


def test_a_shorter_flight_counts_from_an_earlier_time_on():
    assert settled_after(mismatched("small_uav", "zigzag")) == 90.0
    short = mismatched("small_uav", "zigzag", ("mission.duration=20",))
    assert settled_after(short) == pytest.approx(6.0)
    assert settled_after(mismatched("small_uav", "zigzag", ("mission.duration=600",))) == 90.0


def test_no_other_name_is_a_mismatch():
    with pytest.raises(ParameterError, match="mismatch is 'lag_9', must be one of lag_0, lag_0.25"):
        mismatched("small_uav", "lag_9")


def test_in_gusts_the_response_is_told_wrong_likewise():
    still, gusty = mismatched("small_uav", "lag_2"), mismatched("small_uav", "gust_lag_2")
    assert gusty.controller == still.controller
    assert gusty.simulator == mismatched("small_uav", "gust_moderate").simulator


def test_commands_are_delayed_later_in_a_shorter_flight_earlier():
    flown = mismatched("small_uav", "delay_200")
    assert flown.changes == ((120.0, "uav_simulator.command_delay=0.2"),)
    assert flown.simulator.command_delay == 0.0
    ((begin, _),) = mismatched("small_uav", "delay_200", ("mission.duration=30",)).changes
    assert begin == pytest.approx(12.0)


def test_the_roll_is_told_as_the_lag_of_the_same_time():
    flown = mismatched("small_uav", "second_order_roll")
    assert (flown.simulator.roll_frequency, flown.simulator.roll_damping) == (3.0, 0.6)
    assert flown.controller.rate_lag[0] == pytest.approx(0.4)


def test_where_there_is_chance_five_seeds_fly_and_of_weaving_three_periods():
    def of(name):
        return variants(mismatched("small_uav", name), name)

    assert [each.simulator.seed for each in of("gust_lag_0")] == [0, 1, 2, 3, 4]
    assert [each.target.weave_period for each in of("weaving_target")] == [4.0, 8.0, 12.0]
    (late,) = of("delay_100")
    assert late.changes
