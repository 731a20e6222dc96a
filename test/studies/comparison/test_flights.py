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

import numpy as np
import pytest

from uav_tracking_mpc.settings.configuration import load_configuration
from uav_tracking_mpc.simulation.closed_loop import simulate
from uav_tracking_mpc.studies.comparison.flights import fly_all, prepared, start_direction

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
    assert start_direction(flown) == direction
    assert prepared(flown, "nmpc").controller.direction == direction


def test_a_direction_that_is_asked_for_stays():
    flown = configuration("still", "nmpc_controller.direction=counter_clockwise")
    assert start_direction(flown) == "counter_clockwise"
    assert prepared(flown, "nmpc").controller.direction == "counter_clockwise"


def test_flights_do_not_depend_on_processes():
    scenarios = [configuration("gusts"), configuration("noisy_target")]
    laws = ["l1", "vector_field"]
    alone = fly_all(scenarios, laws, workers=1, show=False)
    together = fly_all(scenarios, laws, workers=2, show=False)
    assert len(alone) == len(together) == 2
    for scenario in (0, 1):
        for law in (0, 1):
            one, other = alone[scenario][law], together[scenario][law]
            np.testing.assert_array_equal(one.vehicle, other.vehicle)
    assert not np.array_equal(alone[0][0].vehicle, alone[0][1].vehicle)


def test_all_laws_meet_the_same_start():
    logs = [simulate(prepared(configuration("wind"), law)) for law in ("nmpc", "l1")]
    np.testing.assert_array_equal(logs[0].vehicle[0], logs[1].vehicle[0])
    assert logs[0].orbit == logs[1].orbit
    assert (logs[0].solver, logs[1].solver) == ("newton", "none")
