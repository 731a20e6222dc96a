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
