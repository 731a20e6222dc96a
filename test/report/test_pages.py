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

"""One table, for the terminal and for pages."""

import io

import pytest
from rich.console import Console

from uav_tracking_mpc.report.pages import Table

TABLE = Table(
    headings=("law", "range RMS [m]"),
    rows=[("nmpc", "0.01"), ("", "|x|"), ("l1", "2.50")],
    numeric=("range RMS [m]",),
    caption="RMS of the last third",
)
PAGE = "before\n<!-- table flights -->\n{}<!-- end -->\nafter\n"


def test_markdown_aligns_numbers_and_keeps_bars_inside_cells():
    assert TABLE.as_markdown().splitlines() == [
        "| law | range RMS [m] |",
        "|---|---:|",
        "| nmpc | 0.01 |",
        "|  | \\|x\\| |",
        "| l1 | 2.50 |",
    ]


def test_no_zero_is_negative_in_a_column_of_numbers():
    given = ["-0.000", "-0", "-0.001", "-0.0 %", "0.1 [-0.00, -0.02]", "-10.0"]
    shown = ["0.000", "0", "-0.001", "0.0 %", "0.1 [0.00, -0.02]", "-10.0"]
    headings = ["case", *map(str, range(len(given)))]
    assert Table(headings, [["-0.0", *given]], headings[1:]).rows == [["-0.0", *shown]]


def test_the_terminal_shows_every_cell_and_the_caption():
    file = io.StringIO()
    Console(file=file, width=60).print(TABLE)
    for words in ("law", "[m]", "nmpc", "|x|", "2.50", "RMS of the last third"):
        assert words in " ".join(file.getvalue().split())


def test_a_table_takes_the_place_of_the_one_before(tmp_path):
    page = tmp_path / "page.md"
    page.write_text(PAGE.format("old\n"))
    for _ in range(2):
        TABLE.write_into(page, "flights")
    assert page.read_text() == PAGE.format(TABLE.as_markdown() + "\n")
    assert list(tmp_path.iterdir()) == [page]


def test_a_page_without_the_place_is_refused(tmp_path):
    page = tmp_path / "page.md"
    page.write_text("no place")
    with pytest.raises(ValueError, match=r"page\.md has no place '<!-- table flights -->'"):
        TABLE.write_into(page, "flights")
