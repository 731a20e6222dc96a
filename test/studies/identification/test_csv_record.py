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

"""A record comes back from its CSV file as it was."""

import dataclasses

import numpy as np
import pytest

from uav_tracking_mpc.settings.configuration import load_configuration
from uav_tracking_mpc.simulation.closed_loop import simulate
from uav_tracking_mpc.studies.identification.csv_record import (
    FlightWitness,
    read_csv_record,
    write_record,
)
from uav_tracking_mpc.studies.identification.flight_record import RecordError

MINIMAL = "time,turn_command,path_command,acceleration_command,heading,path_angle\n"


@pytest.fixture(scope="module")
def flown():
    """10 s with a law, which needs no solver; the state comes 0.15 s late."""
    overrides = ["mission.duration=10", "nmpc_controller.law=l1", "uav_simulator.state_delay=0.15"]
    witness = FlightWitness()
    simulate(load_configuration("small_uav", overrides), witness=witness)
    return witness.record()


def test_it_comes_back_bit_for_bit(flown, tmp_path):
    write_record(flown, tmp_path / "out" / "record.csv")
    again = read_csv_record(tmp_path / "out" / "record.csv")
    for field in dataclasses.fields(flown):
        before, after = getattr(flown, field.name), getattr(again, field.name)
        for one, other in zip(before, after, strict=True):
            np.testing.assert_array_equal(one, other)


def test_commands_count_from_when_they_are_given_and_states_from_when_they_were(flown):
    assert flown.heading.time[-1] == pytest.approx(flown.demand.time[-1] - 0.15, abs=0.051)


def test_columns_that_may_be_missing_and_cells_that_may_be_empty(tmp_path):
    path = tmp_path / "flight.csv"
    path.write_text(MINIMAL + "0.0,0.1,0.2,0.3,,\n0.01,,,,1.0,0.5\n0.05,0.2,0.2,0.3,1.1,0.5\n")
    record = read_csv_record(path)
    np.testing.assert_array_equal(record.demand.inputs, [[0.1, 0.2, 0.3], [0.2, 0.2, 0.3]])
    np.testing.assert_array_equal(record.heading.time, [0.01, 0.05])
    assert record.airspeed is None and record.turn_rate is None


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("time,heading\n0,1\n", "has no columns turn_command, path_command"),
        (MINIMAL + "0,1,2,x,0,0\n", "line 2: acceleration_command is 'x', must be a number"),
        (MINIMAL + "0,,,,0,0\n", "holds no command"),
    ],
)
def test_what_is_no_record_is_refused(tmp_path, text, words):
    path = tmp_path / "flight.csv"
    path.write_text(text)
    with pytest.raises(RecordError, match=words):
        read_csv_record(path)
