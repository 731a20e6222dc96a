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

"""What the time strip draws: all of a flight, thinned, in JSON that every browser reads."""

import json
import math
import tracemalloc
from dataclasses import replace

import numpy as np
import pytest
from example_flights import orbiting
from watched_flight_stand_in import StandInFlight, sight

from uav_tracking_mpc import load_configuration
from uav_tracking_mpc.control.fallback import FallbackMode
from uav_tracking_mpc.nodes.messages.named_figures import ERRORS
from uav_tracking_mpc.view.flight_history import (
    COLUMNS,
    MODES,
    MOST,
    FlightHistory,
    row_of,
    weighted_errors,
)
from uav_tracking_mpc.view.recorded_scene import LoggedSource
from uav_tracking_mpc.view.watched_flight import PAST_PERIOD, NodeStatus

TRACKING = load_configuration("small_uav").controller


def strict(text):
    """As a browser reads it: NaN and Infinity are no JSON."""

    def refuse(word):
        raise AssertionError(f"{word} is no JSON")

    return json.loads(text, parse_constant=refuse)


class Flight(StandInFlight):
    tracking = TRACKING  # read once


def noted(times, most=MOST, **more):
    history = FlightHistory(Flight(), most=most)
    for time in times:
        history.note(sight(time, **more))
    return history


def test_a_row_says_what_was_seen():
    seen = sight(12.3, mode=FallbackMode.LOITER, wind=np.array([3.0, 4.0, 0.0]))
    row = dict(zip(COLUMNS, row_of(seen, TRACKING), strict=True))
    assert row["time"] == 12.3
    assert MODES[row["mode"]] is FallbackMode.LOITER
    assert row["range error"] == 0.4
    assert row["altitude"] == 121.0
    assert row["bank"] == pytest.approx(math.degrees(seen.bank), rel=1e-3)
    assert (row["airspeed"], row["wind"], row["cost"]) == (22.5, 5.0, 2.5)


def test_the_weighted_errors_are_those_of_the_stage_cost():
    """Errors of one unit each: what is left is the diagonal of Q."""
    seen = sight(errors=dict.fromkeys(ERRORS, 1.0))
    np.testing.assert_allclose(weighted_errors(seen, TRACKING), TRACKING.state_weights)
    seen = sight(errors=dict.fromkeys(ERRORS, -2.0))
    np.testing.assert_allclose(
        weighted_errors(seen, TRACKING), 4 * np.array(TRACKING.state_weights)
    )


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_what_is_not_finite_is_null(value):
    history = noted([1.0], airspeed=value, cost=value, bank=value, errors={}, target=None)
    told = strict(history.as_json())
    row = dict(zip(told["columns"], told["rows"][0], strict=True))
    unknown = {"bank", "airspeed", "cost", "altitude", "range error", "wind", *ERRORS}
    assert {name for name, number in row.items() if number is None} == unknown


def test_a_long_flight_is_thinned_from_its_begin_to_its_end():
    times = np.arange(0.0, 600.0, PAST_PERIOD)
    told = strict(noted(times, most=500).as_json())
    rows = np.array([row[0] for row in told["rows"]])
    assert 250 <= len(rows) <= 500
    assert rows[0] == 0.0 and rows[-1] >= 597.0
    assert np.ptp(np.diff(rows)) < 1e-6


@pytest.mark.parametrize("begin", [0.0, 1_764_180_000.123_456], ids=["simulated", "real"])
def test_only_what_is_new_is_told(begin):
    """By the time of the last row, to the last digit: a real clock counts from 1970."""
    times = [begin + PAST_PERIOD * k for k in range(4)]
    history = noted(times)
    told = [row[0] for row in strict(history.as_json())["rows"]][-len(times) :]
    assert told == times
    for k, time in enumerate(told):
        assert [row[0] for row in strict(history.as_json(time))["rows"]] == told[k + 1 :]


def test_frames_that_come_seldom_leave_no_gap():
    """What the flight itself has kept fills it."""
    flight = Flight()
    flight.seen = [sight(0.2 * k) for k in range(50)]
    history = FlightHistory(flight)
    history.note(flight.sight)
    assert [row[0] for row in strict(history.as_json())["rows"]] == pytest.approx(
        [0.2 * k for k in range(50)]
    )


def test_changes_of_mode_and_nodes_that_report_worse_are_marked():
    history = FlightHistory(Flight())
    warns = (NodeStatus("target", 1, "lost"),)
    history.note(sight(0.0))
    history.note(sight(0.05, mode=FallbackMode.LOITER, reason="no solution"))
    history.note(sight(0.1, mode=FallbackMode.LOITER, statuses=warns))
    history.note(sight(0.15, mode=FallbackMode.LOITER, statuses=warns))
    history.note(sight(0.2, mode=FallbackMode.SILENCE))
    assert strict(history.as_json())["events"] == [
        [0.0, 0, FallbackMode.OPTIMAL.value],
        [0.05, 1, f"{FallbackMode.LOITER.value}: no solution"],
        [0.1, 1, "target: lost"],
        [0.2, 2, FallbackMode.SILENCE.value],
    ]


def test_what_happens_while_time_stands_is_told_to_who_has_its_rows():
    history = noted([0.0, 0.2])
    history.note(sight(0.2, mode=FallbackMode.SILENCE, reason="disengaged"))
    told = strict(history.as_json(0.2))
    assert (told["rows"], told["events"]) == ([], [[0.2, 2, "silence: disengaged"]])


def test_a_time_that_begins_anew_begins_a_new_history():
    history = noted([5.0, 6.0])
    history.note(sight(0.0))
    told = strict(history.as_json())
    assert told["generation"] == 1
    assert [row[0] for row in told["rows"]] == [0.0]


def test_the_past_is_what_was_kept_by_then():
    history = noted([1.0, 2.0, 3.0])
    assert history.at(2.9).time == 2.0
    assert history.at(0.0).time == 1.0
    assert [seen.time for seen in history.between(1.0, 3.0)] == [2.0, 3.0]
    assert FlightHistory(Flight()).at(1.0) is None


def test_a_record_is_read_to_its_end_though_it_stands_at_its_begin():
    source = LoggedSource(orbiting(61, TRACKING.orbit, 0.5, tracking=TRACKING), TRACKING)
    source.clock.pause()
    (flight,) = source.flights()
    history = FlightHistory(flight, source.clock)
    while len(strict(history.as_json())["rows"]) < 61:
        history.note(flight.sight)
    assert source.clock.time < 1.0
    assert history.at(12.5).time == 12.5
    assert history.at(1e9).time == 30.0


def test_no_flight_takes_more_than_60_mb():
    """However long it is: a tenth of the sights that are kept at most take a tenth of that."""
    history, plan, count = FlightHistory(Flight()), np.zeros((60, 3)), MOST // 10
    seen = sight()
    tracemalloc.start()
    for k in range(count):
        own = {"position": np.zeros(3) + k, "wind": np.zeros(3) + k, "errors": dict(seen.errors)}
        history.note(replace(seen, time=k / 5, plan=plan + k, **own))
    size, _ = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert len(strict(history.as_json())["rows"]) == count
    assert size < 6e6
