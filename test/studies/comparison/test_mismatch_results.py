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

from compared_flights import KEYS, mistold

from uav_tracking_mpc.studies.comparison.mismatch_results import mismatches_as_json


def test_json_has_every_number_of_every_flight_and_what_is_asked():
    content = mismatches_as_json([mistold(), mistold("gust_light")])
    assert json.loads(json.dumps(content, allow_nan=False)) == content
    assert content["config"] == "small_uav"
    flights = content["mismatches"]["lag_2"]
    assert set(flights) == {"nmpc", "l1"}
    assert all(set(flight) == KEYS for flight in flights.values())
    lag = content["asked"]["lag_2"]
    assert (lag["range_rms_m"], lag["bank_rate_rms_dps"]) == (0.5, 3.0)
    assert lag["range_mean_m"] is lag["off_plan"] is lag["of_law"] is None
    assert lag["envelope_violations"] == 0
    assert lag["missed"][0].startswith("range RMS")
    gust = content["asked"]["gust_light"]
    better = content["mismatches"]["gust_light"]["l1"]
    assert gust["range_rms_m"] == 0.7 * better["range_rms_m"]
    assert gust["bank_rate_rms_dps"] == 1.5 * better["bank_rate_rms_dps"]
    assert (gust["of_law"], gust["envelope_violations"]) == ("l1", None)
    assert content["solves"]["lag_2"]["count"] == 0


def test_without_the_controller_nothing_is_asked():
    flown = mistold()
    alone = replace(flown, logs={"l1": flown.logs["l1"]}, measures={"l1": flown.measures["l1"]})
    assert mismatches_as_json([alone])["asked"] == {}


def test_every_answer_of_a_law_that_flies_is_on_its_plan():
    log = mistold().logs["l1"]
    assert log.nominal.all()
    assert len(log.nominal) == len(log.command_time)
    assert mistold().measures["l1"].off_plan == 0
