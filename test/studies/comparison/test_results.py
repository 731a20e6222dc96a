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

import io
import json
from dataclasses import replace

import numpy as np
import pytest
from example_flights import KEYS, compared, mistold
from rich.console import Console

from uav_tracking_mpc.studies.comparison.results import (
    MISTOLD,
    SCENARIOS,
    as_json,
    comparison_table,
    misses,
    others_table,
    own_table,
)


def test_json_has_every_number_of_every_flight():
    scenario = compared()
    content = as_json([scenario])
    assert json.loads(json.dumps(content, allow_nan=False)) == content
    assert content["config"] == "small_uav"
    flights = content["scenarios"]["gusts"]
    assert set(flights) == {"nmpc", "l1"}
    assert all(set(flight) == KEYS for flight in flights.values())
    assert flights["l1"]["settling_s"] is None  # 12 s are not enough
    assert content["targets"]["gusts"]["range_rms_m"] == 0.65
    assert content["targets"]["gusts"]["missed"][1].startswith("within 10 m never")
    assert content["solves"]["gusts"]["count"] == 0


def test_json_of_mismatches_has_what_is_asked():
    content = as_json([mistold(), mistold("gust_light")], MISTOLD)
    assert json.loads(json.dumps(content, allow_nan=False)) == content
    flights = content["mismatches"]["lag_2"]
    assert all(set(flight) == KEYS for flight in flights.values())
    lag = content["asked"]["lag_2"]
    assert (lag["range_rms_m"], lag["bank_rate_rms_dps"]) == (0.5, 3.0)
    assert lag["range_mean_m"] is lag["off_plan"] is lag["of_law"] is None
    assert lag["envelope_violations"] == 0
    assert lag["missed"][0].startswith("range RMS")
    gust = content["asked"]["gust_light"]
    better = content["mismatches"]["gust_light"]["l1"]
    assert gust["range_rms_m"] == 0.7 * better["range_rms_m"]
    assert gust["bank_rate_rms_dps"] == 1.25 * better["bank_rate_rms_dps"]
    assert (gust["of_law"], gust["envelope_violations"]) == ("l1", None)
    assert content["solves"]["lag_2"]["count"] == 0


def test_without_the_controller_nothing_is_asked():
    flown = mistold()
    alone = replace(flown, flights={"l1": flown.flights["l1"]})
    assert as_json([alone], MISTOLD)["asked"] == {}


def test_a_scenario_is_not_compared_with_the_controller_in_another_one():
    one = compared()
    best = replace(one.measures["nmpc"], range_rms_m=0.0, settling_s=0.0)
    assert replace(one, beside={"still": best}).missed == one.missed


def test_every_answer_of_a_law_that_flies_is_on_its_plan():
    log = mistold().logs["l1"]
    assert log.nominal.all()
    assert len(log.nominal) == len(log.command_time)
    assert mistold().measures["l1"].off_plan == 0


def test_what_is_no_number_is_null():
    flown = compared()
    bad = replace(flown.logs["l1"], vehicle=np.full_like(flown.logs["l1"].vehicle, np.nan))
    scenario = replace(flown, flights={"l1": [bad]})
    flight = as_json([scenario])["scenarios"]["gusts"]["l1"]
    assert flight["range_rms_m"] is None
    assert flight["envelope_violations"] == len(bad.time)


def test_solve_times_are_those_of_the_controller():
    flown = compared()
    times = np.full_like(flown.logs["nmpc"].solve_time, 2e-4)
    log = replace(flown.logs["nmpc"], solve_time=times, failures=3)
    scenario = replace(flown, flights={"nmpc": [log]})
    solves = as_json([scenario])["solves"]["gusts"]
    assert (solves["not_converged"], solves["count"]) == (3, len(times))
    assert abs(solves["median_us"] - 200.0) < 1e-6


def test_a_scenario_has_a_title_whoever_wrote_it():
    flown = compared()
    assert flown.title == "Wind with gusts"
    assert "turbulence" in flown.description
    nameless = replace(flown, configuration=replace(flown.configuration, scenario=None))
    assert (nameless.title, nameless.description) == ("gusts", "")


def test_rows_hold_each_flight_and_the_verdict_on_the_controller():
    first, second = comparison_table([compared()]).rows
    assert first[:2] == ["gusts", "nmpc"]
    assert first[3] == "never"
    assert first[-2:] == ["0.65 m, 20 s", "missed"]
    assert second[:2] == ["", "l1"]
    assert second[-2:] == ["", ""]
    assert len(first) == len(second) == len(SCENARIOS.columns) + 4


def test_rows_of_mismatches_say_what_is_asked_as_shares_too():
    flown = [mistold(), mistold("gust_light"), mistold("wind_bias_2")]
    first, second, third, _, fifth, _ = comparison_table(flown, MISTOLD).rows
    assert first[:2] == ["lag_2", "nmpc"]
    assert first[-2:] == ["0.5 m, 3 deg/s", "missed"]
    assert second[-2:] == ["", ""]
    assert third[-2].endswith("deg/s (0.7, 1.25 x l1)")
    assert fifth[-2] == "0.3 m, 2 deg/s, mean 0.1 m"
    assert len(first) == len(MISTOLD.columns) + 4


def test_what_nobody_asks_for_has_no_columns():
    flown = replace(compared(), name="elsewhere")  # for which there is no target
    assert comparison_table([flown]).headings[-1] == "violations"
    assert {len(row) for row in comparison_table([flown]).rows} == {len(SCENARIOS.columns) + 2}


def test_a_page_has_the_controller_and_the_other_laws_in_two_tables():
    flown = [mistold(), mistold("gust_light")]
    rows = comparison_table(flown, MISTOLD).rows
    own, others = own_table(flown), others_table(flown)
    assert own.rows == [[row[0], *row[2:]] for row in rows if row[1] == "nmpc"]
    assert others.headings == ("mismatch", "l1 [m]", "l1 [deg/s]")
    headings = comparison_table(flown, MISTOLD).headings
    places = [headings.index(name) for name in ("range RMS [m]", "bank rate RMS [deg/s]")]
    laws = [[row[place] for place in places] for row in rows if row[1] == "l1"]
    assert [row[1:] for row in others.rows] == laws


@pytest.mark.parametrize(
    ("flown", "kind", "words"),
    [
        (lambda: compared("circling_target", 3.0), SCENARIOS, ("[s]", "circling_target", "missed")),
        (lambda: mistold("gust_light"), MISTOLD, ("gust_light", "off plan")),
    ],
)
def test_the_terminal_shows_every_unit_and_number(flown, kind, words):
    file = io.StringIO()
    Console(file=file, width=140).print(comparison_table([flown()], kind))
    text = file.getvalue()
    assert "…" not in text
    assert all(word in text for word in ("[m]", "[deg/s]", *words))


def test_misses_name_the_scenario_or_the_mismatch():
    assert any(words.startswith("gusts: within 10 m never") for words in misses([compared()]))
    assert misses([mistold()])[0].startswith("lag_2: range RMS")
