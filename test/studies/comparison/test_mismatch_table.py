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

from compared_flights import mistold
from rich.console import Console

from uav_tracking_mpc.studies.comparison.mismatch_table import (
    COLUMNS,
    mismatch_misses,
    mismatch_table,
)


def test_rows_hold_each_flight_and_the_verdict_on_the_controller():
    table = mismatch_table([mistold(), mistold("gust_light"), mistold("wind_bias_2")])
    first, second, third, _, fifth, _ = table.rows
    assert first[:2] == ["lag_2", "nmpc"]
    assert first[-2:] == ["0.5 m, 3 deg/s", "missed"]
    assert second[:2] == ["", "l1"]
    assert second[-2:] == ["", ""]
    assert third[-2].endswith("deg/s (0.7, 1.5 x l1)")
    assert fifth[-2] == "0.3 m, 2 deg/s, mean 0.1 m"
    assert all(len(row) == len(COLUMNS) + 4 for row in table.rows)


def test_the_terminal_shows_every_unit_and_number():
    file = io.StringIO()
    Console(file=file, width=140).print(mismatch_table([mistold("gust_light")]).as_rich())
    text = file.getvalue()
    assert "…" not in text
    for word in ("[m]", "[deg/s]", "gust_light", "off plan"):
        assert word in text


def test_misses_name_the_mismatch():
    assert mismatch_misses([mistold()])[0].startswith("lag_2: range RMS")
