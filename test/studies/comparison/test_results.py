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

import json
from dataclasses import replace

import numpy as np
from compared_flights import KEYS, compared

from uav_tracking_mpc.studies.comparison.results import as_json, scenario_of


def test_json_has_every_number_of_every_flight():
    scenario = compared()
    content = as_json([scenario])
    assert json.loads(json.dumps(content, allow_nan=False)) == content
    assert content["config"] == "small_uav"
    flights = content["scenarios"]["gusts"]
    assert set(flights) == {"nmpc", "l1"}
    assert all(set(flight) == KEYS for flight in flights.values())
    assert flights["l1"]["settling_s"] is None  # 12 s are not enough
    assert content["targets"]["gusts"]["range_rms_m"] == 0.4
    assert content["targets"]["gusts"]["missed"][1].startswith("within 10 m never")
    assert content["solves"]["gusts"]["count"] == 0


def test_what_is_no_number_is_null():
    flown = compared()
    bad = replace(flown.logs["l1"], vehicle=np.full_like(flown.logs["l1"].vehicle, np.nan))
    scenario = scenario_of("gusts", flown.configuration, ["l1"], [bad])
    flight = as_json([scenario])["scenarios"]["gusts"]["l1"]
    assert flight["range_rms_m"] is None
    assert flight["envelope_violations"] == len(bad.time)


def test_solve_times_are_those_of_the_controller():
    flown = compared()
    times = np.full_like(flown.logs["nmpc"].solve_time, 2e-4)
    log = replace(flown.logs["nmpc"], solve_time=times, failures=3)
    scenario = scenario_of("gusts", flown.configuration, ["nmpc"], [log])
    solves = as_json([scenario])["solves"]["gusts"]
    assert solves["not_converged"] == 3
    assert solves["count"] == len(times)
    assert abs(solves["median_us"] - 200.0) < 1e-6


def test_a_scenario_has_a_title_whoever_wrote_it():
    flown = compared()
    assert flown.title == "Wind with gusts"
    assert "turbulence" in flown.description
    nameless = replace(flown, configuration=replace(flown.configuration, scenario=None))
    assert (nameless.title, nameless.description) == ("gusts", "")
