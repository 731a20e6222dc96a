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

"""From an excited flight to the YAML to paste, on the command line."""

import json

import pytest


@pytest.mark.usefixtures("without_report")
def test_a_flight_is_identified_and_people_get_a_table_and_the_yaml(tmp_path, uav_tracking):
    flown, output = tmp_path / "flown", tmp_path / "out"
    few = ("--config", "small_uav", "--duration", 50, "--law", "l1", "--excite")
    uav_tracking.json("simulate", *few, "--output", flown)
    told = uav_tracking.told("identify", flown / "record.csv", "--output", output)
    assert "How the aircraft answers commands" in told
    assert "/**/nmpc_controller:" in told
    content = json.loads((output / "identification.json").read_text())
    truth = {"turn": (0.3, 0.17), "path": (0.13, 0.2), "speed": (0.16, 0.1)}
    for name, (lag, dead_time) in truth.items():
        channel = content["channels"][name]
        assert channel["sure"]
        assert channel["lag_s"]["value"] == pytest.approx(lag, abs=0.02)
        assert channel["dead_time_s"]["value"] == pytest.approx(dead_time, abs=0.02)
        assert channel["gain"]["value"] == pytest.approx(1.0, abs=0.02)
    assert "rate_lag" in content["yaml"]
    assert {path.name for path in output.iterdir()} == {
        "identification.json",
        "identified.yaml",
        "response.png",
    }
