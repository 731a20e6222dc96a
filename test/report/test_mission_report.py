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

"""The report: complete, self-contained, and honest about offsets and failures."""

from __future__ import annotations

import base64
import json
import re
from dataclasses import replace
from html.parser import HTMLParser

import numpy as np
import pytest
from example_flights import log_of, orbiting, paper_flight
from matplotlib.figure import Figure

from uav_tracking_mpc import load_configuration
from uav_tracking_mpc.control.fallback import FallbackMode
from uav_tracking_mpc.dynamics.orbit import COUNTER_CLOCKWISE, Orbit
from uav_tracking_mpc.report import mission_report
from uav_tracking_mpc.report.metrics import metrics, quantity, range_offset_finding, verdict
from uav_tracking_mpc.report.mission_report import Replay, render_page, write_report
from uav_tracking_mpc.simulation.flight_log import CommandCounts, FlightLog, FlownMode, Latency

FILES = {"metrics.json", "trajectory.png", "states.png", "report.html"}


def words(page: str) -> str:
    """What a reader sees: tags and pictures removed, white space made single."""
    body = page.split("<body>")[1]
    return re.sub(r"\s+", " ", re.sub(r"<[^>]*>", " ", body)).replace("\u00a0", " ")


def page_of(log: FlightLog) -> str:
    """The page without its pictures, which take the time."""
    return render_page(log, metrics(log), b"", b"")


@pytest.fixture
def quick_figures(monkeypatch):
    """Files and page are looked at, and not what the figures show."""
    small = Figure((1.0, 1.0))
    for name in ("trajectory_figure", "states_figure", "conditions_figure"):
        monkeypatch.setattr(mission_report, name, lambda log: small)


class Structure(HTMLParser):
    """Collects tags that do not close properly, and every address in the page."""

    VOID = frozenset({"meta", "img", "link", "br"})

    def __init__(self) -> None:
        """Nothing read yet."""
        super().__init__()
        self.open: list[str] = []
        self.addresses: list[str] = []
        self.tags: set[str] = set()

    def handle_starttag(self, tag, attrs):
        """Open."""
        self.tags.add(tag)
        self.addresses += [value for name, value in attrs if name in ("src", "href", "srcset")]
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        """Close what was opened last."""
        assert self.open.pop() == tag


@pytest.fixture(scope="module")
def flown(tmp_path_factory):
    """The paper's model on the true vehicle: folder, numbers, page."""
    folder = tmp_path_factory.mktemp("flight") / "deep" / "output"
    numbers = write_report(paper_flight("paper", "vehicle"), folder)
    return folder, numbers, (folder / "report.html").read_text()


def test_the_folder_is_complete(flown):
    """Made with its parents; four files and no leftovers; metrics.json is what came back."""
    folder, numbers, _ = flown
    assert {path.name for path in folder.iterdir()} == FILES
    assert json.loads((folder / "metrics.json").read_text()) == numbers
    assert numbers == metrics(paper_flight("paper", "vehicle"))


def test_the_page_needs_no_other_file(flown):
    """Well formed, no script, every address is data; the pictures are those beside it."""
    folder, _, page = flown
    structure = Structure()
    structure.feed(page)
    assert not structure.open
    assert not structure.tags & {"script", "iframe", "object"}
    assert not re.search(r"url\(|@import|https?://(?!www\.w3\.org/2000/svg)", page)
    names = ["trajectory.png", "states.png"]
    icon, *pictures = structure.addresses
    assert icon.startswith("data:image/svg+xml")
    assert pictures == [
        "data:image/png;base64," + base64.b64encode((folder / name).read_bytes()).decode()
        for name in names
    ]


def test_the_page_contains_the_numbers(flown):
    """As people read them."""
    _, numbers, page = flown
    text = words(page)
    assert "Flight report: paper" in text
    assert "true vehicle" in text and "the paper model" in text
    for name, unit in (("range", "1 m"), ("altitude", "1 m"), ("bearing", "0.05 rad")):
        assert f"{name}, {unit} {numbers['settling_s'][name]:.0f} s" in text
    assert f"range, RMS {numbers['steady_state']['range_rms_m']:.4f} m" in text
    median = quantity(numbers["solver"]["median_us"], "µs").replace("\u00a0", " ")
    assert f"solve time, median {median}" in text
    assert "Latency" not in text


def test_the_papers_model_is_named_as_the_cause_of_its_offset(flown):
    """Measured offset, and both steady turn rates."""
    _, _, page = flown
    text = words(page)
    assert "Range offset" in text
    assert "0.0284 m too large" in text
    assert "\u2212v_d / r_d = \u22120.026667 rad/s" in text
    assert "\u2212v_d / d_d = \u22120.028284 rad/s" in text


def test_the_exact_model_has_no_offset_to_speak_of():
    """Nor has any model on a plant that is the model."""
    assert "Range offset" not in words(page_of(paper_flight("exact", "vehicle")))
    assert range_offset_finding(paper_flight("paper", "euler")) is None


def test_other_offsets_are_not_blamed_on_the_model():
    """The exact model, 3 m too close."""
    log = orbiting(30)
    log = log_of(log.relative - np.array([3.0, 0.0, 0.0, 0.0, 0.0]))
    text = words(page_of(log))
    assert "3 m too small" in text
    assert "not its cause" in text
    assert "causes it" not in text


def test_an_unsettled_flight_is_not_put_down_to_the_model_alone():
    """The paper's model on the vehicle, stopped while it still approaches."""
    flight = paper_flight("paper", "vehicle")
    cut = {"time": flight.time[:12], "vehicle": flight.vehicle[:12], "target": flight.target[:12]}
    assert "has a part in it" in words(page_of(replace(flight, **cut)))


def test_offset_of_the_counter_clockwise_orbit():
    """Turn rates change sign with the direction."""
    orbit = Orbit(150.0, 50.0, 4.0, COUNTER_CLOCKWISE)
    finding = range_offset_finding(orbiting(30, orbit, model="paper9"))
    assert finding is not None
    assert finding["model_turn_rate"] == pytest.approx(0.03)
    assert finding["exact_turn_rate"] == pytest.approx(4.0 / orbit.radius)
    assert finding["model_formula"] == "v_d r_d / d_d²"


def test_verdicts():
    """Settled or not, how well, and what failed."""
    good = verdict(metrics(orbiting()))
    assert good.startswith("Settled: altitude within 1\u00a0m from 0\u00a0s on")
    far = orbiting(30).relative + np.array([7.0, 0.0, 0.0, 0.0, 0.0])
    bad = verdict(metrics(log_of(far)))
    assert bad.startswith("Not settled: range never came to stay within 1\u00a0m of the reference")
    assert "7\u00a0m too far out" in bad
    trouble = orbiting(failures=3, commands=CommandCounts(failsafe=2))
    assert "3 of 150 solves did not converge." in verdict(metrics(trouble))
    assert "There was no plan 2 times" in verdict(metrics(trouble))
    assert verdict(metrics(orbiting(0))).startswith("No usable record")


@pytest.mark.parametrize(("late", "sound"), [(0, True), (12, True), (290, False)])
def test_a_flight_whose_commands_came_late_is_not_shown_as_good(late, sound):
    page = page_of(orbiting(commands=CommandCounts(sent=1207, late=late)))
    assert ('class="verdict settled"' in page) == sound
    assert ("290 of 1207 commands (24.0%) came late." in words(page)) == (not sound)


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (None, "\u2013"),
        (float("nan"), "\u2013"),
        (float("inf"), "\u2013"),
        (0.0, "0 m"),
        (150.0, "150 m"),
        (-0.5, "\u22120.5 m"),
        (141.4213, "141.4 m"),
        (123456.7, "123457 m"),
        (9.99999, "10 m"),
        (-3e-7, "< 0.0001 m"),
        (0.02843, "0.0284 m"),
    ],
)
def test_quantities_read_well(value, text):
    """Enough digits, not more."""
    assert quantity(value, "m").replace("\u00a0", " ") == text


def test_latency_and_counts_of_a_real_flight():
    """Tables that only a flight with nodes fills."""
    log = orbiting(
        latency=Latency(812.0, 1500.0, 2211.0),
        speed=9.5,
        commands=CommandCounts(sent=150, late=4, plan_reused=2, failsafe=0),
    )
    text = words(page_of(log))
    assert "9.5 times real time" in text
    assert "state to command, median 812 µs" in text
    assert "sent 150" in text and "flown from an earlier plan 2" in text


SCENE = Replay('<!doctype html><script>play("it\'s" & on)</script>', pace=20.0, frames=2)


def test_the_scene_is_inside_and_waits_until_it_is_asked_for():
    """Word for word in a frame of its own that nothing loads before it is opened."""
    log = orbiting(3)
    page = render_page(log, metrics(log), b"", b"", replay=SCENE)
    frames = []
    structure = Structure()
    start = structure.handle_starttag
    structure.handle_starttag = lambda tag, attrs: (  # type: ignore[method-assign]
        frames.append((list(structure.open), dict(attrs))) if tag == "iframe" else None,
        start(tag, attrs),
    )
    structure.feed(page)
    ((above, frame),) = frames
    assert above[-1] == "details"  # closed
    assert frame["data-scene"] == SCENE.html
    assert "src" not in frame and "srcdoc" not in frame
    assert "script" not in structure.tags
    text = words(page)
    assert "One second of the replay is 20 s of the flight" in text
    assert "pip install" not in text


def test_without_viser_one_line_says_how_to_get_the_scene(tmp_path, quick_figures):
    """The rest is as it was."""
    log = orbiting(3)
    write_report(log, tmp_path / "none", lambda _: None)
    write_report(log, tmp_path / "unasked")
    page = (tmp_path / "none" / "report.html").read_text()
    assert page == (tmp_path / "unasked" / "report.html").read_text()
    assert 'pip install "uav_tracking_mpc[view]"' in words(page).replace("&#34;", '"')
    assert "<iframe" not in page


def test_a_real_aircraft_has_a_picture_of_its_limits(tmp_path, quick_figures):
    """Beside the others, and in the page."""
    small_uav = load_configuration("small_uav").controller
    log = orbiting(20, small_uav.orbit, tracking=small_uav)
    write_report(log, tmp_path)
    assert {path.name for path in tmp_path.iterdir()} == FILES | {"conditions.png"}
    picture = base64.b64encode((tmp_path / "conditions.png").read_bytes()).decode()
    assert picture in (tmp_path / "report.html").read_text()


def test_fallbacks_are_listed_with_their_reasons():
    """The twelve longest, in the order in which they were flown."""
    modes = [FlownMode(0.0, FallbackMode.OPTIMAL)]
    for k in range(20):
        modes.append(FlownMode(4.0 * k + 1.0, FallbackMode.LOITER, f"reason {k}"))
        modes.append(FlownMode(4.0 * k + 1.0 + 0.1 * (k + 1), FallbackMode.OPTIMAL))
    page = words(page_of(orbiting(101, modes=tuple(modes))))
    assert "Fallback mode" in page
    assert re.findall(r"reason (\d+)", page) == [str(k) for k in range(8, 20)]
    assert "loiter law 33 s 0.9 s reason 8" in page
    assert "It fell back 20 times. These are the 12 longest:" in page
    assert "Fallback mode" not in words(page_of(orbiting(3)))


def test_names_are_escaped():
    """A configuration's name is text, whatever it holds."""
    page = page_of(orbiting(3, config="<script>alert(1)</script>"))
    assert "<script" not in page
    assert "&lt;script&gt;" in page


@pytest.mark.parametrize("count", [0, 1])
def test_short_records_make_a_report(count, tmp_path, quick_figures):
    """A flight that was stopped at once."""
    write_report(orbiting(count), tmp_path)
    assert {path.name for path in tmp_path.iterdir()} == FILES


def test_values_that_are_not_finite_make_a_report(tmp_path):
    """Dashes and nulls, never nan."""
    log = orbiting(20)
    vehicle = np.full_like(log.vehicle, np.nan)
    log = replace(log, vehicle=vehicle, cost=np.full(19, np.nan), solve_time=np.full(19, np.nan))
    write_report(log, tmp_path)
    assert "NaN" not in (tmp_path / "metrics.json").read_text()
    assert not re.search(r"\b(nan|inf|None)\b", words((tmp_path / "report.html").read_text()))


def test_a_second_report_replaces_the_first(tmp_path, quick_figures):
    """Whole files; a link out of the folder is replaced, not followed."""
    elsewhere = tmp_path / "elsewhere.json"
    elsewhere.write_text("untouched")
    folder = tmp_path / "output"
    write_report(orbiting(3), folder)
    (folder / "metrics.json").unlink()
    (folder / "metrics.json").symlink_to(elsewhere)
    numbers = write_report(orbiting(4), folder)
    assert elsewhere.read_text() == "untouched"
    assert json.loads((folder / "metrics.json").read_text()) == numbers
    assert {path.name for path in folder.iterdir()} == FILES


def test_an_output_that_cannot_be_written_is_named(tmp_path, quick_figures):
    """A file where the folder should be."""
    (tmp_path / "output").write_text("a file")
    with pytest.raises(OSError, match="cannot write the report") as raised:
        write_report(orbiting(3), tmp_path / "output")
    assert str(tmp_path / "output") in str(raised.value)
