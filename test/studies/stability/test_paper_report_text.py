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

"""The report on the paper for people; the page in docs is current."""

from pathlib import Path

from pages import assert_same

from uav_tracking_mpc.studies.stability.paper_report import paper_report
from uav_tracking_mpc.studies.stability.paper_report_text import (
    as_markdown,
    numbers_table,
    verdicts,
)

PAGE = Path(__file__).resolve().parents[3] / "docs" / "paper_errata.md"


def test_every_row_has_a_verdict():
    rows = paper_report()
    assert [row[0] for row in numbers_table(rows).rows] == [str(n + 1) for n in range(len(rows))]
    lines = verdicts(rows)
    assert [int(line.split()[0]) for line in lines] == list(range(1, len(rows) + 1))
    assert any("the printed certificate does not hold" in line for line in lines)


def test_the_page_is_current():
    assert_same(PAGE.read_text(), as_markdown(paper_report()))
