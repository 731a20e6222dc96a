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

"""Plans as they were flown."""

import numpy as np
import pytest

from uav_tracking_mpc.dynamics.gravity import GRAVITY
from uav_tracking_mpc.studies.identification.flight_record import (
    Demand,
    FlightRecord,
    FlownPlan,
    RecordError,
    flown_demand,
    samples,
)


def plan(time, begin, values, step=0.4):
    inputs = np.column_stack([values, np.zeros(len(values)), np.zeros(len(values))])
    return FlownPlan(time, begin + step * np.arange(len(values)), inputs)


def test_a_plan_counts_from_when_it_came_to_when_the_next_one_does():
    """It is laid out from the stamp of the state that it answers: what is over is not flown."""
    demand = flown_demand([plan(0.1, 0.0, [1.0, 2.0, 3.0]), plan(0.9, 0.45, [4.0, 5.0, 6.0])])
    np.testing.assert_allclose(demand.time, [0.1, 0.4, 0.8, 0.9, 1.25])
    np.testing.assert_array_equal(demand.inputs[:, 0], [1.0, 2.0, 3.0, 5.0, 6.0])


def test_of_a_flight_with_a_gap_the_longer_part_is_used():
    before = [plan(0.4 * k, 0.4 * k, [1.0]) for k in range(3)]
    after = [plan(20.0 + 0.4 * k, 20.0 + 0.4 * k, [2.0]) for k in range(5)]
    assert set(flown_demand([*before, *after]).inputs[:, 0]) == {2.0}


def test_without_commands_there_is_nothing_to_identify():
    with pytest.raises(RecordError, match="no commands"):
        flown_demand([])


def test_samples_are_put_in_order_and_doubles_and_gaps_left_out():
    kept = samples([2.0, 1.0, 1.0, 3.0], [20.0, 10.0, 11.0, np.nan])
    np.testing.assert_array_equal(kept.time, [1.0, 2.0])
    np.testing.assert_array_equal(kept.value, [10.0, 20.0])


def record(airspeed=True, rate=0.1):
    time = np.arange(0.0, 30.0, 0.05)
    inputs = np.tile([0.1, 0.0, 0.0], (len(time), 1))
    heading = (0.1 * time + np.pi) % (2.0 * np.pi) - np.pi
    return FlightRecord(
        Demand(time, inputs),
        samples(time, heading),
        samples(time, np.zeros_like(time)),
        samples(time, np.full_like(time, 20.0)) if airspeed else None,
        samples(time, rate + 0.001 * np.sin(time)),
        samples(time, np.zeros_like(time)),
    )


def test_heading_is_unwrapped_and_a_turn_banks_by_its_airspeed():
    turn, path, speed = record().channels()
    np.testing.assert_allclose(np.diff(turn.state.value), 0.005)
    np.testing.assert_allclose(turn.leverage, 20.0 / GRAVITY)
    assert (turn.name, path.name, speed.name) == ("turn", "path", "speed")


def test_a_rate_that_stands_still_is_not_measured():
    turn, path, _ = record().channels()
    assert turn.rate is not None and path.rate is None


def test_without_airspeed_there_is_no_speed_channel():
    assert [channel.name for channel in record(airspeed=False).channels()] == ["turn", "path"]
