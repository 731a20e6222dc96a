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

from compared_flights import compared, mistold

from uav_tracking_mpc.studies.comparison.comparison_page import write_comparison, write_mismatches
from uav_tracking_mpc.studies.comparison.mismatch_results import mismatches_as_json
from uav_tracking_mpc.studies.comparison.results import as_json


def test_the_folder_tells_the_comparison(tmp_path):
    scenarios = [compared("still"), compared("gusts")]
    numbers = as_json(scenarios)
    write_comparison(numbers, scenarios, tmp_path / "new")
    names = {path.name for path in (tmp_path / "new").iterdir()}
    assert names == {"compare.json", "compare.html", "summary.png", "still.png", "gusts.png"}
    assert json.loads((tmp_path / "new" / "compare.json").read_text()) == numbers
    page = (tmp_path / "new" / "compare.html").read_text()
    assert page.count("data:image/png;base64,") == 3
    assert "Wind with gusts" in page
    assert "gusts: within 10 m never" in page
    assert "http" not in page


def test_another_folder_tells_what_happens_where_it_is_told_wrong(tmp_path):
    mismatches = [mistold(), mistold("gust_light")]
    numbers = mismatches_as_json(mismatches)
    write_mismatches(numbers, mismatches, tmp_path / "new")
    names = {path.name for path in (tmp_path / "new").iterdir()}
    assert names == {"mismatches.json", "mismatches.html", "mismatches.png"}
    assert json.loads((tmp_path / "new" / "mismatches.json").read_text()) == numbers
    page = (tmp_path / "new" / "mismatches.html").read_text()
    assert page.count("data:image/png;base64,") == 1
    assert "Guidance laws told wrong: small_uav" in page
    assert "lag_2: range RMS" in page
