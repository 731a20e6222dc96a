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

import dataclasses
import json
from functools import cache

import pytest
from example_flights import compared, mistold
from matplotlib.markers import CARETLEFT, CARETRIGHT

from uav_tracking_mpc.report.figure_style import LAWS
from uav_tracking_mpc.studies.comparison.figures import comparison, overview_figure, scenario_figure
from uav_tracking_mpc.studies.comparison.results import MISTOLD, SCENARIOS


@cache
def picture(name):
    return scenario_figure(compared(name))


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("still", []),
        ("gusts", ["wind 5 m/s and gusts"]),
        ("circling_target", ["wind 5 m/s", "target 5 m/s at the start"]),
    ],
)
def test_the_picture_of_a_scenario_shows_what_moves(name, expected):
    words = [text.get_text() for text in picture(name).axes[0].texts]
    assert [each for each in words if each] == expected


def test_a_picture_begins_where_the_aircraft_is_seen_and_its_words_have_one_meaning_each():
    """The target is what is circled; a bank is positive with the right wing down."""
    top_view, error, bank = picture("circling_target").axes
    assert top_view.lines[1].get_xydata()[0] == pytest.approx([591.608, 0.0], abs=1e-3)
    assert "asked of nmpc" in error.get_title("left") and "target" not in error.get_title("left")
    assert "right wing down" in bank.get_title("left")


def test_there_is_a_mark_for_every_flight_and_a_bar_for_what_is_asked():
    mismatches = [mistold(), mistold("gust_light")]
    figure = overview_figure(mismatches, MISTOLD)
    ranges, bank_rates = figure.axes
    assert [label.get_text() for label in ranges.get_yticklabels()] == ["lag_2", "gust_light"]
    own, other, bar, *_ = ranges.lines
    assert own.get_color() == LAWS["nmpc"]
    assert own.get_xdata()[0] == mismatches[0].measures["nmpc"].range_rms_m
    assert other.get_xdata()[0] == mismatches[0].measures["l1"].range_rms_m
    assert list(bar.get_xdata()) == [0.5, 0.5]
    better = mismatches[1].measures["l1"].bank_rate_rms_dps
    assert list(bank_rates.lines[-1].get_xdata()) == pytest.approx([1.25 * better] * 2)


def test_an_axis_spans_a_decade_so_that_it_names_no_more_than_its_decades():
    still = compared("still")
    slow = {
        law: dataclasses.replace(flight, bank_rate_rms_dps=0.6 + 0.02 * k)
        for k, (law, flight) in enumerate(still.measures.items())
    }
    changed = dataclasses.replace(still)
    vars(changed)["measures"] = slow
    least, most = overview_figure([changed]).axes[-1].get_xlim()
    assert most > 10.0 * least


def test_what_the_axis_cannot_show_points_beyond_it():
    still = compared("still")
    changed = dataclasses.replace(still)
    fine = dataclasses.replace(still.measures["nmpc"], range_rms_m=2e-4)
    vars(changed)["measures"] = {**still.measures, "nmpc": fine}
    figure = overview_figure([changed])
    ranges, settling, _ = figure.axes
    assert [line.get_marker() for line in ranges.lines[:2]] == [CARETLEFT, "s"]
    assert [line.get_marker() for line in settling.lines[:2]] == [CARETRIGHT] * 2  # never, in 12 s
    words = [words.get_text() for words in figure.legends[0].get_texts()]
    assert words == ["nmpc", "l1", "less than is drawn", "never", "asked of nmpc"]


@pytest.mark.parametrize(
    ("flown", "kind", "pictures", "words"),
    [
        (
            lambda: [compared("still"), compared("gusts")],
            SCENARIOS,
            {"summary.png", "still.png", "gusts.png"},
            ("Wind with gusts", "gusts: within 10 m never"),
        ),
        (
            lambda: [mistold(), mistold("gust_light")],
            MISTOLD,
            {"mismatches.png"},
            ("Guidance laws under mismatch: small_uav", "lag_2: range RMS"),
        ),
    ],
)
def test_the_folder_tells_the_comparison(tmp_path, flown, kind, pictures, words):
    study, folder, name = comparison(flown(), kind), tmp_path / "new", kind.name
    told = study.publish(folder)
    assert {path.name for path in folder.iterdir()} == {f"{name}.json", f"{name}.html", *pictures}
    assert all(path.stat().st_size < 300_000 for path in folder.glob("*.png"))
    assert json.loads((folder / f"{name}.json").read_text()) == study.content
    assert told[-1] == f"report: {folder / name}.html"
    page = (folder / f"{name}.html").read_text()
    assert page.count("data:image/png;base64,") == len(pictures)
    assert all(each in page for each in words)
    assert "http" not in page


@pytest.mark.parametrize(("left", "written"), [("", "| gusts | nmpc |"), ("some", "before")])
def test_documentation_changes_only_with_all_that_was_asked_for(tmp_path, left, written):
    page = tmp_path / "page.md"
    page.write_text("<!-- table comparison -->\nbefore\n<!-- end -->\n")
    comparison([compared()], SCENARIOS, left).document(page)
    assert written in page.read_text()
