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

import functools

import pytest

from uav_tracking_mpc.cli.main import main
from uav_tracking_mpc.studies.identification import identification

identified = functools.cache(identification.identification)


@pytest.fixture(autouse=True)
def _once(monkeypatch):
    monkeypatch.setattr(identification, "identification", identified)


@pytest.fixture(scope="module")
def flight(tmp_path_factory):
    folder = tmp_path_factory.mktemp("flight")
    few = ["--config", "small_uav", "--duration", "60", "--json", "--law", "l1"]
    assert main(["simulate", *few, "--excite", "--output", str(folder)]) == 0
    return folder


def test_a_flight_is_identified(flight, tmp_path, uav_tracking):
    output = tmp_path / "out"
    content = uav_tracking.json("identify", flight / "record.csv", "--output", output)
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


def test_people_get_a_table_and_the_yaml(flight, uav_tracking):
    out = uav_tracking.told("identify", flight / "record.csv")
    assert "How the aircraft answers commands" in out
    assert "/**/nmpc_controller:" in out
