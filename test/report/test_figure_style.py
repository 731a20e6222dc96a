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

"""Figures exist at their size and leave nothing behind; laws keep their colours."""

from __future__ import annotations

import struct

import matplotlib
import pytest
from example_flights import moving_target, orbiting, paper_flight, with_holes
from matplotlib.figure import Figure

from uav_tracking_mpc.report import time_panels, trajectory
from uav_tracking_mpc.report.figure_style import DPI, LAWS, OTHERS, colours, save_figure


def pixels(png: bytes) -> tuple[int, int]:
    """Width and height that a PNG file states."""
    assert png.startswith(b"\x89PNG")
    return struct.unpack(">II", png[16:24])


FLIGHTS = {
    "no sample": lambda: orbiting(0),
    "one sample": lambda: orbiting(1),
    "the paper's": paper_flight,
    "moving target": moving_target,
    "holes": with_holes,
}


# The others are drawn by test_time_panels.py and in every report.
@pytest.mark.parametrize(
    "flight",
    [
        pytest.param(flight, marks=[pytest.mark.long] * (flight not in ("no sample", "holes")))
        for flight in FLIGHTS
    ],
)
def test_files_have_their_size(flight, tmp_path):
    """Whatever was flown, the file is a PNG of the stated size, and what was returned."""
    log = FLIGHTS[flight]()
    for figure, size in (
        (trajectory.trajectory_figure(log), trajectory.SIZE),
        (time_panels.states_figure(log), time_panels.SIZE),
    ):
        path = tmp_path / "figure.png"
        content = save_figure(figure, path)
        assert path.read_bytes() == content
        assert pixels(content) == (round(size[0] * DPI), round(size[1] * DPI))
        assert len(content) > 20_000
    assert [path.name for path in tmp_path.iterdir()] == ["figure.png"]


def test_no_state_is_left_in_matplotlib(tmp_path):
    """No pyplot figure stays open, no setting stays changed."""
    from matplotlib import pyplot

    before, settings = pyplot.get_fignums(), dict(matplotlib.rcParams)
    save_figure(trajectory.trajectory_figure(orbiting(5)), tmp_path / "trajectory.png")
    assert pyplot.get_fignums() == before
    assert dict(matplotlib.rcParams) == settings


def test_a_users_settings_do_not_change_the_size(tmp_path):
    """savefig.bbox = tight is common in people's matplotlibrc."""
    with matplotlib.rc_context({"savefig.bbox": "tight", "savefig.dpi": 50}):
        content = save_figure(Figure((4.0, 3.0)), tmp_path / "empty.png")
    assert pixels(content) == (4 * DPI, 3 * DPI)


def test_a_missing_folder_is_an_oserror(tmp_path):
    """Nothing is made up: the caller says where."""
    with pytest.raises(OSError, match="nowhere"):
        save_figure(Figure(), tmp_path / "nowhere" / "empty.png")


def test_a_law_keeps_its_colour_whoever_is_beside_it():
    assert colours(["l1"])["l1"] == colours(["nmpc", "pursuit", "l1"])["l1"] == LAWS["l1"]


def test_laws_that_nobody_has_seen_take_colours_that_are_not_reserved():
    found = colours(["pursuit", "nmpc", "other", "pursuit"])
    assert list(found) == ["pursuit", "nmpc", "other"]
    assert found["pursuit"] != found["other"]
    assert {found["pursuit"], found["other"]} <= set(OTHERS)
    assert len(colours(f"law{n}" for n in range(20))) == 20
