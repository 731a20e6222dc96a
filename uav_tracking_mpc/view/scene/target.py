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

"""The target: where it is estimated, how surely, where it was measured, where it is expected."""

from __future__ import annotations

import math

import numpy as np
import viser
from numpy.typing import NDArray

from uav_tracking_mpc.view.scene import SceneElement
from uav_tracking_mpc.view.scene._drawing import GREY, Mesh, extent, finite, ring, turned
from uav_tracking_mpc.view.watched_flight import Sight, TargetSight

SHARE = 0.14  # height of the pin by the radius of the orbit
SIGMAS = 3.0
CHANGE = 0.03  # least change of the uncertainty, by itself, that is drawn
STANDING = 0.25  # m/s; slower is called standing
CROSS = np.array(
    [[[-1.0, -1.0, 0.0], [1.0, 1.0, 0.0]], [[-1.0, 1.0, 0.0], [1.0, -1.0, 0.0]]]
)  # fmt: skip


def pin() -> Mesh:
    """A pin that stands on its tip, 1 high."""
    points, faces = turned([(0.0, 0.0), (0.65, 0.24), (0.85, 0.24), (1.0, 0.0)])
    return points[:, [1, 2, 0]], faces


def caption(target: TargetSight) -> str:
    """What stands above the target: how fast it moves, in half metres a second.

    Args:
        target: As it is seen.
    """
    if target.velocity is None or not finite(target.velocity):
        return "target"
    speed = float(np.linalg.norm(target.velocity))
    return "target" if speed < STANDING else f"target {0.5 * round(2.0 * speed):.1f} m/s"


class Target(SceneElement):
    """A pin with its 3-sigma sphere; a cross where it was measured, a circle where it truly is."""

    name = "target"

    def add(self) -> None:
        """Send what is moved later."""
        place, self._std = f"{self.root}/target", 0.0
        self._place = self.scene.add_frame(place, show_axes=False, visible=False)
        self._pin = self.scene.add_mesh_simple(
            f"{place}/pin", *pin(), color=self.colour, side="double"
        )
        self._sure = self.scene.add_icosphere(
            f"{place}/three_sigma",
            radius=1.0,
            subdivisions=2,
            color=self.colour,
            opacity=0.2,
            cast_shadow=False,
            receive_shadow=False,
            visible=False,
        )
        self._label = self.scene.add_label(f"{place}/label", "target", anchor="bottom-center")
        self._measured, self._truth = (
            self.add_lines(f"{place}_{name}", points, GREY, 2.0)
            for name, points in (("measured", CROSS), ("truth", ring()))
        )

    def show(self, sight: Sight) -> None:
        """Move it to where it is.

        Args:
            sight: Of this aircraft.
        """
        target, size = sight.target, SHARE * extent(self.flight, sight)
        known = target is not None and finite(target.position)
        self._place.visible = known
        if target is None or not known:
            self._measured.visible = self._truth.visible = False
            return
        self._place.position = target.position
        self._pin.scale = size
        self._label.position = (0.0, 0.0, 1.1 * size)
        self._label.text = caption(target)
        self._show_std(target.std)
        _mark(self._measured, target.measured, 0.15 * size)
        hidden = target.truth is not None and np.allclose(target.truth, target.position, atol=0.1)
        _mark(self._truth, None if hidden else target.truth, 0.2 * size)

    def _show_std(self, std: float) -> None:
        self._sure.visible = math.isfinite(std) and std > 0.0
        if self._sure.visible and abs(std - self._std) > CHANGE * std:
            self._std, self._sure.scale = std, SIGMAS * std


def _mark(
    lines: viser.LineSegmentsHandle, position: NDArray[np.float64] | None, size: float
) -> None:
    lines.visible = position is not None and finite(position)
    if position is not None and lines.visible:
        lines.position, lines.scale = position, size


ANEW = 0.5  # s of the flight's clock between two forecasts that are sent


class Forecast(SceneElement):
    """Where the target is expected, with circles of three standard deviations along the way."""

    name = "forecast"

    def add(self) -> None:
        """Begin with none."""
        self._shown = -math.inf
        self._lines = self.add_lines(f"{self.root}/forecast", np.zeros((1, 2, 3)), self.colour, 1.5)

    def show(self, sight: Sight) -> None:
        """Draw the forecast of now.

        Args:
            sight: Of this aircraft.
        """
        forecast = None if sight.target is None else sight.target.forecast
        if forecast is None or not finite(forecast, sight.time):
            self._lines.visible = False
            return
        self._lines.visible = float(np.ptp(forecast[:, :2], axis=0).max()) > STANDING
        if not self._lines.visible:
            return
        if 0.0 <= sight.time - self._shown < ANEW:
            return
        self._shown = sight.time
        places, stds = forecast[:, :3], forecast[:, 3]
        parts = [np.stack([places[:-1], places[1:]], axis=1)]
        parts += [
            place + SIGMAS * std * ring() for place, std in zip(places[1:], stds[1:], strict=True)
        ]
        self._lines.points = np.concatenate(parts).astype(np.float32)
