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

import numpy as np
from example_flights import ORBIT, log_of, paper_flight

from uav_tracking_mpc.report import states
from uav_tracking_mpc.report.figure_style import BLUE


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
