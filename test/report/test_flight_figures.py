"""Figures: they exist at their size, show what was flown, and leave nothing behind."""

from __future__ import annotations

import struct
from dataclasses import replace
from pathlib import Path

import matplotlib
import numpy as np
import pytest
from example_flights import ORBIT, log_of, orbiting, paper_flight
from uav_tracking_mpc.report.flight_figures import save_states, save_trajectory

from uav_tracking_mpc.dynamics.orbit import COUNTER_CLOCKWISE, Orbit
from uav_tracking_mpc.report import states, trajectory
from uav_tracking_mpc.report.figure_style import BLUE, DPI
from uav_tracking_mpc.simulation.flight_log import FlightLog


def pixels(png: bytes) -> tuple[int, int]:
    """Width and height that a PNG file states."""
    assert png.startswith(b"\x89PNG")
    return struct.unpack(">II", png[16:24])


def moving_target() -> FlightLog:
    """Several orbits about a target that drives away at 2 m/s."""
    log = orbiting(600, Orbit(300.0, 120.0, 22.0, COUNTER_CLOCKWISE), step=0.5)
    target = np.outer(log.time, [2.0, 1.0, 0.0])
    vehicle = log.vehicle.copy()
    vehicle[:, :3] += target
    return replace(log, vehicle=vehicle, target=target)


def with_holes() -> FlightLog:
    """Samples, costs and a bound that are not finite."""
    log = orbiting(40)
    vehicle, cost = log.vehicle.copy(), log.cost.copy()
    vehicle[3:6] = np.nan
    cost[::2] = np.nan
    upper = np.array([np.inf, 1.0, 1.0])
    return replace(log, vehicle=vehicle, cost=cost, input_upper=upper)


FLIGHTS = {
    "no sample": lambda: orbiting(0),
    "one sample": lambda: orbiting(1),
    "the paper's": paper_flight,
    "moving target": moving_target,
    "holes": with_holes,
}


@pytest.mark.parametrize("flight", FLIGHTS)
def test_files_have_their_size(flight, tmp_path):
    """Whatever was flown, the file is a PNG of the stated size, and what was returned."""
    log = FLIGHTS[flight]()
    for save, size in ((save_trajectory, trajectory.SIZE), (save_states, states.SIZE)):
        path = tmp_path / "figure.png"
        content = save(log, path)
        assert path.read_bytes() == content
        assert pixels(content) == (round(size[0] * DPI), round(size[1] * DPI))
        assert len(content) > 20_000
    assert [path.name for path in tmp_path.iterdir()] == ["figure.png"]


def test_no_state_is_left_in_matplotlib(tmp_path):
    """No pyplot figure stays open, no setting stays changed."""
    from matplotlib import pyplot

    before, settings = pyplot.get_fignums(), dict(matplotlib.rcParams)
    save_trajectory(orbiting(5), tmp_path / "trajectory.png")
    save_states(orbiting(5), tmp_path / "states.png")
    assert pyplot.get_fignums() == before
    assert dict(matplotlib.rcParams) == settings


def test_a_users_settings_do_not_change_the_size(tmp_path):
    """savefig.bbox = tight is common in people's matplotlibrc."""
    with matplotlib.rc_context({"savefig.bbox": "tight", "savefig.dpi": 50}):
        content = save_states(orbiting(5), tmp_path / "states.png")
    assert pixels(content) == (round(states.SIZE[0] * DPI), round(states.SIZE[1] * DPI))


def test_bearing_is_drawn_without_jumps():
    """A bearing that passes through pi on its way to the reference, and ends there."""
    theta = np.linspace(1.5 * np.pi, 0.5 * np.pi, 50)
    relative = np.tile(ORBIT.steady_state, (50, 1))
    relative[:, 1] = theta
    figure = states.states_figure(log_of(relative))
    panel = next(axes for axes in figure.axes if axes.get_title(loc="left").endswith("Bearing"))
    (line,) = (line for line in panel.lines if line.get_color() == BLUE)
    np.testing.assert_allclose(np.asarray(line.get_ydata()), theta, atol=1e-9)
    low, high = panel.get_ylim()
    assert low < theta.min() and theta.max() < high


def test_inputs_are_drawn_held_between_their_bounds():
    """Steps from command to command, the last one to the end; limits show both bounds."""
    log = paper_flight()
    figure = states.states_figure(log)
    panel = next(axes for axes in figure.axes if "Turn rate" in axes.get_title(loc="left"))
    (line,) = (line for line in panel.lines if line.get_color() == BLUE)
    assert line.get_drawstyle() == "steps-post"
    assert np.asarray(line.get_xdata())[-1] == log.time[-1]
    low, high = panel.get_ylim()
    assert low < log.input_lower[0] and log.input_upper[0] < high


def test_every_panel_has_a_unit_and_shares_the_time_axis():
    """Ten panels, (a) to (j)."""
    figure = states.states_figure(paper_flight())
    assert len(figure.axes) == 10
    for letter, axes in zip("afbgchdiej", figure.axes, strict=True):
        assert axes.get_title(loc="left").startswith(f"({letter}) ")
        assert axes.get_ylabel().endswith("]")
        assert axes.get_xlim() == (0.0, 150.0)


def test_the_trajectory_is_to_scale():
    """A metre is as long along each axis."""
    figure = trajectory.trajectory_figure(paper_flight())
    (axes,) = figure.axes
    limits = [axes.get_xlim3d(), axes.get_ylim3d(), axes.get_zlim3d()]
    extent = np.ptp(limits, axis=1)
    ratio = axes._box_aspect / extent
    np.testing.assert_allclose(ratio, ratio[0])
    assert limits[2][0] <= 0.0  # the target's ground is in the picture


def test_time_marks_do_not_hide_each_other():
    """Several orbits pass the same places: labels stay apart, and some remain."""
    for log in (paper_flight(), moving_target()):
        figure = trajectory.trajectory_figure(log)
        figure.canvas.draw()
        boxes = [text.get_window_extent() for text in figure.axes[0].texts]
        assert len(boxes) >= 5
        for index, box in enumerate(boxes):
            assert not any(box.overlaps(other) for other in boxes[:index])
            assert box.x0 > 0.0 and box.x1 < figure.bbox.width


def test_everything_drawn_lies_inside_the_figure():
    """Axis labels included, for flat and for tall flights."""
    tall = orbiting(100)
    vehicle = tall.vehicle.copy()
    vehicle[:, 2] += np.linspace(800.0, 0.0, 100)
    for log in (paper_flight(), moving_target(), replace(tall, vehicle=vehicle)):
        figure = trajectory.trajectory_figure(log)
        box = trajectory._scene_box(figure, figure.axes[0])
        assert box.x0 >= 0.0 and box.x1 <= 1.0
        assert box.y0 >= 0.0 and box.y1 <= 0.95


def test_a_missing_folder_is_an_oserror(tmp_path):
    """Nothing is made up: the caller says where."""
    with pytest.raises(OSError, match="nowhere"):
        save_states(orbiting(2), Path(tmp_path / "nowhere" / "states.png"))
