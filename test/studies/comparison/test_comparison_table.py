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

from compared_flights import compared
from rich.console import Console

from uav_tracking_mpc.studies.comparison.comparison_table import (
    COLUMNS,
    comparison_rows,
    comparison_table,
    misses,
)


def test_rows_hold_each_flight_and_the_verdict_on_the_controller():
    first, second = comparison_rows([compared()])
    assert first[:2] == ["gusts", "nmpc"]
    assert first[3] == "never"
    assert first[-2:] == ["0.4 m, 20 s", "missed"]
    assert second[:2] == ["", "l1"]
    assert second[-2:] == ["", ""]
    assert len(first) == len(second) == len(COLUMNS) + 4


def test_the_terminal_shows_every_unit_and_number():
    file = io.StringIO()
    Console(file=file, width=140).print(
        comparison_table([compared("circling_target", 3.0)]).as_rich()
    )
    text = file.getvalue()
    assert "…" not in text
    for word in ("[m]", "[s]", "[deg/s]", "circling_target", "missed"):
        assert word in text


def test_misses_name_the_scenario():
    assert any(words.startswith("gusts: within 10 m never") for words in misses([compared()]))
