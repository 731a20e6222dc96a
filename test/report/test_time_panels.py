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

"""States, inputs and cost over time."""

from dataclasses import replace

import numpy as np
import pytest
from example_flights import ORBIT, log_of, moving_target, orbiting, paper_flight, with_holes
from matplotlib.colors import to_rgba

from uav_tracking_mpc import load_configuration
from uav_tracking_mpc.control.fallback import FallbackMode
from uav_tracking_mpc.dynamics.air import GRAVITY
from uav_tracking_mpc.dynamics.vehicle import velocity
from uav_tracking_mpc.report import time_panels
from uav_tracking_mpc.report.figure_style import BLUE, MODES, VERMILLION
from uav_tracking_mpc.report.time_panels import conditions_figure, has_conditions
from uav_tracking_mpc.simulation.flight_log import FlownMode


def test_bearing_is_drawn_without_jumps():
    """A bearing that passes through pi on its way to the reference, and ends there."""
    theta = np.linspace(1.5 * np.pi, 0.5 * np.pi, 50)
    relative = np.tile(ORBIT.steady_state, (50, 1))
    relative[:, 1] = theta
    figure = time_panels.states_figure(log_of(relative))
    panel = next(axes for axes in figure.axes if axes.get_title(loc="left").endswith("Bearing"))
    (line,) = (line for line in panel.lines if line.get_color() == BLUE)
    np.testing.assert_allclose(np.asarray(line.get_ydata()), theta, atol=1e-9)
    low, high = panel.get_ylim()
    assert low < theta.min() and theta.max() < high


def test_each_state_has_one_reference_also_where_another_was_asked_for_in_flight():
    """The orbit of the end is not drawn over the whole flight."""
    log = paper_flight()
    wider = replace(log.orbit, range=log.orbit.range + 50.0)
    for orbits, points in (((), 2), (((0.0, wider), (80.0, log.orbit)), len(log.time))):
        figure = time_panels.states_figure(replace(log, orbits=orbits))
        axes = panel(figure, "Range")
        (reference,) = (each for each in axes.lines if each.get_linestyle() == "--")
        assert len(reference.get_xdata()) == points


def test_inputs_are_drawn_held_between_their_bounds():
    """Steps from command to command, the last one to the end; limits show both bounds."""
    log = paper_flight()
    figure = time_panels.states_figure(log)
    panel = next(axes for axes in figure.axes if "Turn rate" in axes.get_title(loc="left"))
    (line,) = (line for line in panel.lines if line.get_color() == BLUE)
    assert line.get_drawstyle() == "steps-post"
    assert np.asarray(line.get_xdata())[-1] == log.time[-1]
    low, high = panel.get_ylim()
    assert low < log.input_lower[0] and log.input_upper[0] < high


def test_every_panel_has_a_unit_and_shares_the_time_axis():
    """Ten panels, (a) to (j)."""
    figure = time_panels.states_figure(paper_flight())
    assert len(figure.axes) == 10
    for letter, axes in zip("afbgchdiej", figure.axes, strict=True):
        assert axes.get_title(loc="left").startswith(f"({letter}) ")
        assert axes.get_ylabel().endswith("]")
        assert axes.get_xlim() == (0.0, 150.0)


WIND = np.array([3.0, -4.0, 0.0])


@pytest.fixture(scope="module")
def small_uav():
    """Parameters of the controller of `small_uav`."""
    return load_configuration("small_uav").controller


@pytest.fixture
def log(small_uav):
    """Two minutes on its orbit in 5 m/s of wind; from 60 s to 70 s the target is lost."""
    log = orbiting(241, small_uav.orbit, step=0.5, tracking=small_uav)
    ground = np.array([velocity(state) for state in log.vehicle]) + WIND
    modes = (
        FlownMode(0.0, FallbackMode.OPTIMAL),
        FlownMode(60.0, FallbackMode.LOITER, "target position is lost"),
        FlownMode(70.0, FallbackMode.OPTIMAL),
    )
    return replace(log, ground_velocity=ground, modes=modes)


def panel(figure, title):
    (found,) = (axes for axes in figure.axes if axes.get_title(loc="left")[4:].startswith(title))
    return found


def line(axes, colour):
    """Values of the one curve of a colour; limits are lines of two points."""
    curves = (each for each in axes.lines if len(each.get_xdata()) > 2)
    (found,) = (each for each in curves if each.get_color() == colour)
    return np.asarray(found.get_ydata())


def limits(axes):
    """Levels of the lines that show limits."""
    shown = [each for each in axes.lines if each.get_color() == VERMILLION]
    return sorted(np.asarray(each.get_ydata())[0] for each in shown)


def test_bank_airspeed_and_path_angle_are_between_their_limits(log, small_uav):
    """Drawn where the aircraft has them, inside the panel, in degrees."""
    figure = conditions_figure(log)
    envelope = small_uav.envelope
    expected = {
        "Bank": np.degrees([-envelope.bank_max, envelope.bank_max]),
        "Airspeed": [envelope.airspeed_min, envelope.airspeed_max],
        "Path angle": np.degrees([envelope.path_angle_min, envelope.path_angle_max]),
    }
    for title, levels in expected.items():
        axes = panel(figure, title)
        assert limits(axes) == pytest.approx(list(levels))
        low, high = axes.get_ylim()
        assert low < levels[0] and levels[1] < high


def test_the_bank_is_that_of_the_turn(log, small_uav):
    """tan(phi) = v^2 / (g R), right wing down on a clockwise orbit."""
    orbit = small_uav.orbit
    expected = np.degrees(np.arctan(orbit.speed**2 / (GRAVITY * orbit.radius)))
    bank = line(panel(conditions_figure(log), "Bank"), BLUE)
    np.testing.assert_allclose(bank, expected, atol=0.02)


def test_wind_and_drift_are_drawn(log):
    """The target moves with the wind: no drift is left."""
    figure = conditions_figure(replace(log, target_velocity=np.tile(WIND, (len(log.time), 1))))
    air = panel(figure, "Wind and drift")
    np.testing.assert_allclose(line(air, BLUE), 5.0)
    np.testing.assert_allclose(line(air, VERMILLION), 0.0, atol=1e-9)
    assert air.get_title(loc="right").startswith("blows towards 143")
    np.testing.assert_allclose(line(panel(figure, "Target's speed"), BLUE), 5.0)


def test_a_target_that_moves_for_a_time_does_not_stand(log):
    moved = np.zeros((len(log.time), 3))
    for moving, words in ((0, "it stands"), (5, "")):
        moved[:moving, 0] = 5.0
        axes = panel(conditions_figure(replace(log, target_velocity=moved)), "Target's speed")
        assert axes.get_title(loc="right") == words


def test_each_mode_has_a_row_and_a_bar_for_its_time(log):
    """Best first; the loiter law from 60 s to 70 s."""
    axes = panel(conditions_figure(log), "Mode")
    names = [label.get_text() for label in axes.get_yticklabels()]
    assert names == ["optimal plan", "loiter law"]
    bars = {}
    for bar in axes.collections:
        box = bar.get_paths()[0].get_extents()
        bars.setdefault(tuple(bar.get_facecolor()[0]), []).append((box.x0, box.x1))
    assert bars[to_rgba(MODES[FallbackMode.LOITER])] == [(60.0, 70.0)]
    assert bars[to_rgba(MODES[FallbackMode.OPTIMAL])] == [(0.0, 60.0), (70.0, 120.0)]
    assert axes.get_title(loc="right") == "fell back once"


def test_every_mode_has_a_colour():
    assert set(MODES) == set(FallbackMode)


def test_it_is_drawn_where_there_is_something_to_show(log, small_uav):
    """By limits in the problem, wind or a moving target; not for the paper's point mass."""
    paper = load_configuration("paper").controller
    calm = replace(orbiting(), tracking=paper)
    assert not has_conditions(calm)
    assert not has_conditions(paper_flight())
    assert has_conditions(replace(calm, tracking=small_uav))
    assert has_conditions(replace(log, tracking=paper))  # in wind
    moving = np.tile([1.0, 0.0, 0.0], (len(calm.time), 1))
    assert has_conditions(replace(calm, target_velocity=moving))


def test_limits_that_the_controller_does_not_know_are_not_drawn(log):
    """The paper's, in wind."""
    figure = conditions_figure(replace(log, tracking=load_configuration("paper").controller))
    assert limits(panel(figure, "Bank")) == []


@pytest.mark.parametrize("flight", [moving_target, with_holes, lambda: log_of(np.empty((0, 5)))])
def test_any_record_can_be_drawn(flight):
    """Holes, nothing at all, modes that nobody recorded."""
    figure = conditions_figure(flight())
    figure.canvas.draw()
    assert [text.get_text() for text in panel(figure, "Mode").texts] == ["not recorded"]
