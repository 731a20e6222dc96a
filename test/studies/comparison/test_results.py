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

from uav_tracking_mpc.simulation.flight_log import SensorNews
from uav_tracking_mpc.studies.comparison.results import (
    MISTOLD,
    SCENARIOS,
    as_json,
    comparison_table,
    misses,
    news_of_sensors,
    not_its_own,
    others_table,
    own_table,
)


def test_json_has_every_number_of_every_flight():
    content = as_json([compared()])
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
    assert all(set(flight) == KEYS for flight in content["mismatches"]["lag_2"].values())
    lag, gust = content["asked"]["lag_2"], content["asked"]["gust_light"]
    assert (lag["range_rms_m"], lag["bank_rate_rms_dps"]) == (0.5, 3.0)
    assert lag["range_mean_m"] is lag["off_plan"] is lag["of_law"] is None
    assert lag["envelope_violations"] == 0
    assert lag["missed"][0].startswith("range RMS")
    better = content["mismatches"]["gust_light"]["l1"]
    assert gust["range_rms_m"] == 0.7 * better["range_rms_m"]
    assert gust["bank_rate_rms_dps"] == 1.25 * better["bank_rate_rms_dps"]
    assert (gust["of_law"], gust["envelope_violations"]) == ("l1", None)
    flown = mistold()
    alone = replace(flown, flights={"l1": flown.flights["l1"]})
    assert as_json([alone], MISTOLD)["asked"] == {}  # without the controller


def test_a_scenario_is_not_compared_with_the_controller_in_another_one():
    one = compared()
    best = replace(one.measures["nmpc"], range_rms_m=0.0, settling_s=0.0)
    assert replace(one, beside={"still": best}).missed == one.missed


def test_every_answer_of_a_law_that_flies_is_on_its_plan():
    log = mistold().logs["l1"]
    assert log.nominal.all()
    assert len(log.nominal) == len(log.command_time)
    assert mistold().measures["l1"].off_plan == 0


def test_commands_that_were_not_by_the_law_are_told():
    flown = mistold()
    log, late = flown.logs["l1"], flown.logs["l1"].nominal.copy()
    assert not_its_own([flown]) == []
    late[-3:] = False
    (line,) = not_its_own([replace(flown, flights={"l1": [replace(log, nominal=late)]})])
    assert line.startswith("lag_2: 3 commands that count were not by l1")


def test_what_is_no_number_is_null_and_solve_times_are_those_of_the_controller():
    flown = compared()
    bad = replace(flown.logs["l1"], vehicle=np.full_like(flown.logs["l1"].vehicle, np.nan))
    times = np.full_like(flown.logs["nmpc"].solve_time, 2e-4)
    slow = replace(flown.logs["nmpc"], solve_time=times, failures=3)
    content = as_json([replace(flown, flights={"nmpc": [slow], "l1": [bad]})])
    flight, solves = content["scenarios"]["gusts"]["l1"], content["solves"]["gusts"]
    assert flight["range_rms_m"] is None
    assert flight["envelope_violations"] == len(bad.time)
    assert (solves["not_converged"], solves["count"]) == (3, len(times))
    assert abs(solves["median_us"] - 200.0) < 1e-6


def test_a_scenario_has_a_title_whoever_wrote_it():
    flown = compared()
    title, description = flown.about
    assert title == "Wind with gusts"
    assert "turbulence" in description
    nameless = replace(flown, configuration=replace(flown.configuration, scenario=None))
    assert nameless.about == ("gusts", "")


def test_rows_hold_each_flight_and_the_verdict_on_the_controller():
    first, second = comparison_table([compared()]).rows
    assert first[:2] == ["gusts", "nmpc"]
    assert first[3] == "never"
    assert first[-2:] == ["0.65 m, 20 s", "missed"]
    assert second[:2] == ["", "l1"]
    assert second[-2:] == ["", ""]
    assert len(first) == len(second) == len(SCENARIOS.columns) + 4
    unasked = comparison_table([replace(compared(), name="elsewhere")])
    assert unasked.headings[-1] == "violations"
    assert {len(row) for row in unasked.rows} == {len(SCENARIOS.columns) + 2}


def test_rows_of_mismatches_say_what_is_asked_as_shares_too():
    """On a page of the documentation, controller and other laws have a table each."""
    flown = [mistold(), mistold("gust_light"), mistold("wind_bias_2")]
    table, own, others = comparison_table(flown, MISTOLD), own_table(flown), others_table(flown)
    asked = {row[0]: row[-2:] for row in table.rows if row[1] == "nmpc"}
    assert asked["lag_2"] == ["0.5 m, 3 deg/s", "missed"]
    assert asked["gust_light"][0].endswith("deg/s (0.7, 1.25 x l1)")
    assert asked["wind_bias_2"][0] == "0.3 m, 2 deg/s, mean 0.1 m"
    assert own.rows == [[row[0], *row[2:]] for row in table.rows if row[1] == "nmpc"]
    assert {len(row) for row in own.rows} == {len(own.headings)}
    assert list(others.headings) == ["mismatch", "l1 [m]", "l1 [deg/s]"]
    places = [table.headings.index(name) for name in ("range RMS [m]", "bank rate RMS [deg/s]")]
    laws = [[row[place] for place in places] for row in table.rows if row[1] == "l1"]
    assert [row[1:] for row in others.rows] == laws


def test_without_the_law_whose_shares_are_asked_for_nothing_is_reached():
    both = mistold("gust_light")
    alone = replace(both, flights={"nmpc": both.flights["nmpc"]})
    assert not alone.missed
    assert comparison_table([alone], MISTOLD).rows[0][-2:] == ["(0.7, 1.25 x l1)", "not compared"]


@pytest.mark.parametrize(
    ("flown", "kind", "words"),
    [(compared, SCENARIOS, ("[s]", "gusts", "missed")), (mistold, MISTOLD, ("lag_2", "off plan"))],
)
def test_the_terminal_shows_every_unit_and_number(flown, kind, words):
    file = io.StringIO()
    Console(file=file, width=140).print(comparison_table([flown()], kind))
    text = file.getvalue()
    assert "…" not in text
    assert all(word in text for word in ("[m]", "[deg/s]", *words))


def test_misses_and_news_name_the_scenario_or_the_mismatch():
    assert any(words.startswith("gusts: within 10 m never") for words in misses([compared()]))
    assert misses([mistold()])[0].startswith("lag_2: range RMS")
    news = [SensorNews(float(time), "airspeed", "off") for time in range(8)]
    log = replace(mistold().logs["nmpc"], sensors=tuple(news))
    (line,) = news_of_sensors([replace(mistold(), flights={"nmpc": [log]})])
    assert line.startswith("lag_2: airspeed off after 0.0 s, ")
    assert line.endswith("airspeed off after 5.0 s, 2 more")
