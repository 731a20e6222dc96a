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

"""The flight in space: to scale, inside the figure, with marks that do not hide each other."""

from dataclasses import replace

import numpy as np
import pytest
from example_flights import moving_target, orbiting, paper_flight
from matplotlib.figure import Figure

from uav_tracking_mpc.report import trajectory


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


@pytest.mark.parametrize("centre", [0.0, 700.0, -3000.0])
def test_numbers_of_two_axes_do_not_meet_in_their_common_corner(centre):
    """A twentieth of each axis stays free at both of its ends, wherever the flight is."""
    axes = Figure().add_subplot(projection="3d")
    corners = np.array([[-150.0, -90.0, 0.0], [150.0, 210.0, 50.0]])
    trajectory._frame(axes, corners + np.array([centre, centre, 0.0]))
    for axis, (begin, end) in ((axes.xaxis, axes.get_xlim3d()), (axes.yaxis, axes.get_ylim3d())):
        share = (axis.get_majorticklocs() - begin) / (end - begin)
        assert len(share) >= 2
        assert share.min() >= 0.05 and share.max() <= 0.95
