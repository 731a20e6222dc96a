import io

import pytest
from compared_flights import compared
from rich.console import Console

from uav_tracking_mpc.studies.comparison.command import WIDTH
from uav_tracking_mpc.studies.comparison.comparison_table import (
    BEGIN,
    COLUMNS,
    END,
    as_markdown,
    as_table,
    misses,
    rows,
    write_into,
)


def test_rows_hold_each_flight_and_the_verdict_on_the_controller():
    first, second = rows([compared()])
    assert first[:2] == ["gusts", "nmpc"]
    assert first[3] == "never"
    assert first[-2:] == ["0.4 m, 20 s", "missed"]
    assert second[:2] == ["", "l1"]
    assert second[-2:] == ["", ""]
    assert len(first) == len(second) == len(COLUMNS) + 4


def test_the_terminal_shows_every_unit_and_number():
    file = io.StringIO()
    Console(file=file, width=WIDTH).print(as_table([compared("circling_target", 3.0)]))
    text = file.getvalue()
    assert "…" not in text
    for word in ("[m]", "[s]", "[deg/s]", "circling_target", "missed"):
        assert word in text


def test_misses_name_the_scenario():
    assert any(words.startswith("gusts: settled never") for words in misses([compared()]))


def test_a_table_is_put_into_a_page_and_into_no_other(tmp_path):
    page = tmp_path / "page.md"
    page.write_text(f"before\n{BEGIN}old\n{END}\nafter\n")
    for _ in range(2):
        write_into(page, as_markdown([compared()]))
    lines = page.read_text().splitlines()
    assert lines[0] == "before"
    assert lines[-1] == "after"
    assert len(lines) == 8
    assert len({line.count("|") for line in lines[2:6]}) == 1
    page.write_text("no place")
    with pytest.raises(ValueError, match="has no place"):
        write_into(page, "")
