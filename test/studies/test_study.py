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

"""A study is written whole, whatever its numbers are."""

import json
import math

from uav_tracking_mpc.studies.study import Study


def test_a_number_that_is_not_finite_is_null_and_costs_no_other(tmp_path):
    study = Study("found", {"cost": math.inf, "of": {"flights": (1, math.nan)}}, ["words"])
    assert study.content == {"cost": None, "of": {"flights": [1, None]}}
    assert study.publish(tmp_path) == ["words"]
    assert json.loads((tmp_path / "found.json").read_text(encoding="utf-8")) == study.content
