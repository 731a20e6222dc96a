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

"""The target: estimated, measured, expected, and dragged by the mouse over the ground."""

from __future__ import annotations

import asyncio
import math
from typing import Any

import numpy as np
import viser
import viser.transforms as rigid
from numpy.typing import ArrayLike, NDArray

from uav_tracking_mpc.view.scene import (
    GREY,
    Mesh,
    SceneElement,
    extent,
    finite,
    joined,
    ring,
    turned,
)
from uav_tracking_mpc.view.watched_flight import TARGET, Sight, TargetSight

SHARE = 0.14  # height of the pin by the radius of the orbit
SIGMAS = 3.0
CHANGE = 0.03  # least change of the uncertainty, by itself, that is drawn
STANDING = 0.25  # m/s; slower is called standing
CROSS = np.array(
    [[[-1.0, -1.0, 0.0], [1.0, 1.0, 0.0]], [[-1.0, 1.0, 0.0], [1.0, -1.0, 0.0]]]
)  # fmt: skip


def pin() -> Mesh:
    """A pin that stands on its tip, 1 high."""
    return turned([(0.0, 0.0), (0.65, 0.24), (0.85, 0.24), (1.0, 0.0)], upright=True)


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


HINT = "drag me"
HANDLE = 0.11  # outer radius of the handle by the radius of the orbit
HEAD = np.array([[0.75, -0.2, 0.0], [0.75, 0.2, 0.0], [1.0, 0.0, 0.0]])  # -, by that radius
RAISED = 0.01  # of the handle over the ground, by its radius
FARTHEST = 30.0  # by the radius of the orbit; near the horizon a pixel is kilometres
NOTICE = 10.0  # s that a refusal stays


def meets_height(
    origin: ArrayLike, through: ArrayLike, height: float
) -> NDArray[np.float64] | None:
    """Where a ray meets a horizontal plane.

    Args:
        origin: Of the ray, shape (3,), in [m].
        through: A point on it, shape (3,), in [m].
        height: Of the plane in [m].

    Returns:
        Shape (3,), in [m]; None where the ray leads away from the plane or along it.
    """
    begin, along = np.asarray(origin, dtype=float), np.subtract(through, origin)
    rise, climb = height - begin[2], along[2]
    if not finite(begin, along, height) or rise * climb <= 0.0:
        return None
    return begin + along * (rise / climb)


def handle() -> Mesh:
    """A flat ring of radius 0.7 with four arrow heads that end at 1."""
    ways = [rigid.SO3.from_z_radians(0.5 * math.pi * k) for k in range(4)]
    heads = [(np.array(way.apply(HEAD), dtype=float), np.array([[0, 1, 2]])) for way in ways]
    return joined(turned([(0.0, 0.55), (0.0, 0.7)], 48, upright=True), *heads)


class TargetDrag(SceneElement):
    """A ghost of the pin follows the pointer; where it is let go the target is sent.

    The pin is taken, or the handle under it. A hint says so until the target was sent once.
    """

    name = "target_drag"

    def add(self) -> None:
        """Send the ghost, hidden."""
        self._pin: viser.MeshHandle | None = None
        self._target: NDArray[np.float64] | None = None
        self._size = 1.0
        ghost = f"{self.root}/target_ghost"
        self._ghost = self.scene.add_frame(ghost, show_axes=False, visible=False)
        self._shape = self.scene.add_mesh_simple(
            f"{ghost}/pin", *pin(), color=self.colour, opacity=0.5, side="double"
        )
        self._label = self.scene.add_label(f"{ghost}/label", "", anchor="bottom-center")
        self._handle = self.scene.add_mesh_simple(
            f"{self.root}/target_handle",
            *handle(),
            color=self.colour,
            opacity=0.6,
            side="double",
            visible=False,
        )
        self._hint = self.scene.add_label(
            f"{self.root}/target_hint", HINT, anchor="top-center", visible=False
        )
        self._sent = False

    def show(self, sight: Sight) -> None:
        """Take note of where the target is, and let it be dragged as soon as it can be.

        Args:
            sight: Of this aircraft.
        """
        known = sight.target is not None and finite(sight.target.position)
        self._target = sight.target.position if sight.target is not None and known else None
        self._size = extent(self.flight, sight)
        steering = self.flight.steering
        if self._pin is None and steering is not None and TARGET in steering.nodes:
            pin_there = self.scene.get_handle_by_name(f"{self.root}/target/pin")
            if isinstance(pin_there, viser.MeshHandle):
                self._pin = pin_there
                for taken in (self._pin, self._handle):
                    taken.on_drag(self._dragged)
        self._handle.visible = self._pin is not None and self._target is not None
        self._hint.visible = self._handle.visible and not self._sent
        if self._target is not None and self._handle.visible:
            radius = HANDLE * self._size
            self._handle.scale = radius
            self._handle.position = np.add(self._target, (0.0, 0.0, RAISED * radius))
            self._hint.position = np.subtract(self._target, (0.0, 1.1 * radius, 0.0))

    async def _dragged(self, event: Any) -> None:
        """Called in order on the loop of the server, so that it must not block."""
        place = self._place(event)
        if event.phase != "end":
            self._show_ghost(place)
            return
        self._ghost.visible = False
        if place is not None:
            loop = asyncio.get_running_loop()
            loop.run_in_executor(None, self._send, event.client, place)

    def _place(self, event: Any) -> NDArray[np.float64] | None:
        """Where the target would stand: it keeps its distance to the pointer on the ground."""
        if self._target is None:
            return None
        grabbed, pointer, camera = (
            _in_map(self.root, event.client, point)
            for point in (event.start_position, event.end_position, event.client.camera.position)
        )
        met = meets_height(camera, pointer, grabbed[2])
        if met is None or np.linalg.norm(met - grabbed) > FARTHEST * self._size:
            return None
        return self._target + (met - grabbed)

    def _show_ghost(self, place: NDArray[np.float64] | None) -> None:
        if place is None:
            return
        east, north, _ = place.tolist()
        self._ghost.visible, self._ghost.position = True, place
        self._shape.scale = SHARE * self._size
        self._label.position = (0.0, 0.0, 1.1 * SHARE * self._size)
        self._label.text = f"to {east:.0f} m east, {north:.0f} m north"

    def _send(self, client: viser.ClientHandle, place: NDArray[np.float64]) -> None:
        steering = self.flight.steering
        assert steering is not None, "nobody drags it before there is one"
        refusal = steering.send_target(float(place[0]), float(place[1]))
        self._sent = self._sent or not refusal
        if refusal:
            client.add_notification(
                "The target cannot go there", refusal, color="red", auto_close_seconds=NOTICE
            )


def _in_map(root: str, client: viser.ClientHandle, point: ArrayLike) -> NDArray[np.float64]:
    """A point that a client told, who may see the whole scene moved with an aircraft."""
    world = client.scene.get_handle_by_name("/" + root.split("/")[1])
    if world is None:
        return np.asarray(point, dtype=float)
    turned = rigid.SO3(np.array(world.wxyz)).inverse().as_matrix()
    moved = turned @ (np.asarray(point, dtype=float) - world.position)
    return np.asarray(moved, dtype=float)
