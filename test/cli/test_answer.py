"""What a command prints: JSON alone, or words and whole tables."""

import json

import pytest

from uav_tracking_mpc.cli.answer import answer
from uav_tracking_mpc.report.table import Table


def test_json_is_all_that_is_printed(capsys):
    answer({"range_m": 1.5, "name": "x"}, ["words"], as_json=True)
    assert json.loads(capsys.readouterr().out) == {"range_m": 1.5, "name": "x"}


def test_json_knows_no_nan():
    with pytest.raises(ValueError, match="JSON"):
        answer({"range_m": float("nan")}, [], as_json=True)


def test_a_table_is_never_cut_off(capsys):
    headings = [f"a long heading {n}" for n in range(20)]
    table = Table(headings, [[f"cell number {n}" for n in range(20)]])
    answer({}, ["[before]", table.as_rich()], as_json=False)
    text = capsys.readouterr().out
    assert text.startswith("[before]\n")
    assert all(f"cell number {n}" in text for n in range(20))
