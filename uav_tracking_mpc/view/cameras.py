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

"""From where each page looks: at the orbit, at an aircraft, from above, from the cockpit, freely.

A camera that follows does not move: the scene is moved under it, for that page alone. So nothing
ever moves the camera but the mouse, and both go together. The first seconds turn the scene in the
same way: a stranger sees that it is one that can be turned.
"""

from __future__ import annotations

import math
import time
from collections import deque
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
import viser
import viser.transforms as rigid
from numpy.typing import NDArray

from uav_tracking_mpc.simulation.flight_log import FlightLog
from uav_tracking_mpc.view.scene import centre, extent, finite, ground_height, own_node
from uav_tracking_mpc.view.scene.airframe import SHARE, attitude
from uav_tracking_mpc.view.watched_flight import Sight, WatchedFlight

ORBIT, FOLLOW, ABOVE, COCKPIT, FREE = (
    "the orbit", "follow", "from above", "from the cockpit", "free",
)  # fmt: skip
VIEWS = ORBIT, FOLLOW, ABOVE, COCKPIT, FREE
FIELD_OF_VIEW = math.radians(50.0)  # upright
NEAR, FAR = 0.5, 50_000.0  # m
MARGIN = 1.4  # of what is to be in the picture
WIDEST = 1.25  # width by height of a picture up to which an orbit fills the width
ELEVATION = math.radians(22.0)
BEHIND, OVER = 0.75, 0.3  # where a camera that follows begins, by the radius of the orbit
FAR_TARGET = 4.0  # by the radius of the orbit: a target that goes farther is followed
FARTHEST = 2.5  # by the radius of the orbit: how far off the aircraft still is in the first view
STEP = 0.5  # by the radius of the orbit, in which it counts how far off the aircraft is
BESIDE = 0.1  # of that: on the orbit, an aircraft is as often a little outside as inside
TILT = 1e-3  # rad; straight down, north would be nowhere
# On a phone the panel covers the lower part once unfolded: the middle stands so far up, by half a
# picture.
UP = 0.2
OPENING = 3.0  # s of wall time in which the scene of a new page turns into its place
OPENING_TURN = math.radians(50.0)  # by which that begins
RESHAPED = 0.01  # of a picture's width by its height; less of a change is none
LEGEND = 280.0  # pixels from the left that the legend takes
ROOM = 840  # pixels; a smaller scene it would cover
LAST_FIRST = 10  # first views that a page may have begun with while it was loaded

Watched = tuple[WatchedFlight, Sight]
Frame = viser.FrameHandle


class Pose(NamedTuple):
    """Where a camera stands and what it looks at.

    Attributes:
        position: In [m], shape (3,).
        look_at: In [m], shape (3,).
    """

    position: NDArray[np.float64]
    look_at: NDArray[np.float64]


def covered(width: float, aspect: float) -> float:
    """Share of a scene's width that the legend covers; 0 where it is folded, since it is small.

    Args:
        width: Of the scene in pixels of the page, of which a screen may have several; nan where it
            is not known.
        aspect: That width by the scene's height [-].
    """
    return LEGEND / width if width >= ROOM and aspect >= 1.0 else 0.0


def first_pose(view: str, watched: Watched, aspect: float, covered: float = 0.0) -> Pose:
    """Where a camera begins, in the axes in which the page then sees the scene.

    Args:
        view: One of VIEWS.
        watched: The aircraft that is looked at.
        aspect: Width of the picture by its height [-].
        covered: Share of that width, from the left, that is not free [-].
    """
    flight, sight = watched
    size, middle = extent(flight, sight), centre(sight)
    away = float(np.hypot(*(sight.position - middle)[:2]))
    # In whole steps: pages that are opened one after the other begin alike.
    steps = min(max(math.ceil(away / (STEP * size) - BESIDE), 1.0 / STEP), FARTHEST / STEP)
    reach = MARGIN * STEP * size * steps
    # From so low an orbit is higher than a picture only where that is much wider than high.
    free = min(aspect * (1.0 - covered), 1.0 if view == ABOVE else WIDEST)
    back = reach / (math.tan(0.5 * FIELD_OF_VIEW) * free)
    if view == FREE:
        return _from_south(middle, back, ELEVATION, aspect, covered)
    floor = np.array([0.0, 0.0, 0.5 * (float(middle[2]) + ground_height(sight))])
    if view in (ORBIT, ABOVE):
        elevation = ELEVATION if view == ORBIT else 0.5 * math.pi - TILT
        return _from_south(floor, back, elevation, aspect, covered)
    if view == FOLLOW:
        behind = [-BEHIND * math.cos(sight.heading), -BEHIND * math.sin(sight.heading), OVER]
        return Pose(size * np.array(behind), np.zeros(3))
    over = SHARE * size * np.array([0.1, 0.0, 0.4])  # the arrows of the wind lie beneath
    return Pose(over, over + np.array([1.0, 0.0, 0.0]))


def _from_south(
    middle: NDArray[np.float64], back: float, elevation: float, aspect: float, covered: float = 0.0
) -> Pose:
    """Look at a point from the south, at an angle above the ground in [rad].

    It stands in the middle of what is free.
    """
    sine, cosine = math.sin(elevation), math.cos(elevation)
    half = back * math.tan(0.5 * FIELD_OF_VIEW)  # of the picture's height
    aside, upright = covered * aspect * half, UP * half if aspect < 1.0 else 0.0
    look_at = middle - np.array([aside, upright * sine, upright * cosine])
    return Pose(look_at + back * np.array([0.0, -cosine, sine]), look_at)


def scene_pose(view: str, sight: Sight) -> rigid.SE3:
    """How the scene is moved for a page.

    Args:
        view: One of VIEWS.
        sight: Of the aircraft that is looked at.
    """
    if view == FREE:
        return rigid.SE3.identity()
    if view in (ORBIT, ABOVE):
        return rigid.SE3.from_translation(-centre(sight) * [1.0, 1.0, 0.0])
    if view == COCKPIT:
        turned = rigid.SO3(np.array(attitude(sight)))
        return rigid.SE3.from_rotation_and_translation(turned, sight.position).inverse()
    return rigid.SE3.from_translation(-sight.position)


def look_at_whole(camera: viser.InitialCameraConfig, flight: WatchedFlight, log: FlightLog) -> bool:
    """Put a camera where it sees a whole flight, from the south and above.

    Args:
        camera: Of the scene.
        flight: At its begin.
        log: Of the whole flight.

    Returns:
        Whether the target goes so far that the scene is to be moved with it: the first view is then
        that of the live page.
    """
    camera.fov, camera.near, camera.far = FIELD_OF_VIEW, NEAR, FAR
    sight = flight.sight
    assert sight is not None, "a log has one at each time"
    size = extent(flight, sight)
    places, targets = (
        each[np.isfinite(each).all(axis=1)] for each in (log.vehicle[:, :3], log.target)
    )
    if len(targets) and np.linalg.norm(np.ptp(targets, axis=0)) > FAR_TARGET * size:
        moved = scene_pose(ABOVE, sight).translation()
        camera.position, camera.look_at = (
            place + moved for place in first_pose(FREE, (flight, sight), 1.0)
        )
        return True
    low, high = (limit([*places, *targets], axis=0) for limit in (np.min, np.max))
    middle, reach = 0.5 * (low + high), max(0.5 * float(np.linalg.norm(high - low)), size)
    back = reach / math.tan(0.5 * FIELD_OF_VIEW)
    camera.position, camera.look_at = _from_south(middle, back, ELEVATION, 1.0)
    return False


class Seat:
    """From where one page looks.

    Args:
        client: The page.
        world: Name of the node under which the whole scene hangs.
        firsts: Where pages began, newest last.

    Attributes:
        world: That node as this page sees it.
        width: Of the scene in pixels of the page; nan until the page has told it.
    """

    def __init__(
        self, client: viser.ClientHandle, world: str, firsts: Sequence[NDArray[np.float64]]
    ) -> None:
        self._client, self._firsts = client, firsts
        self.world = client.scene.add_frame(world, show_axes=False)
        self._view = client.gui.add_dropdown("Camera", VIEWS, order=-2.0)
        self._names: tuple[str, ...] = ()
        self._chosen: viser.GuiDropdownHandle[str] | None = None
        self._to_place = False  # it stands where all pages begin, or where its address says
        self.width = math.nan
        self._aspect = self._covered = math.nan  # of the picture for which it was placed
        self._orbit_known = False  # when it was placed
        self._placed = np.full(3, math.nan)
        self._began: float | None = None  # s, when the scene was first seen
        self._own: dict[str, viser.FrameHandle] = {}
        self._view.on_update(self._place_again)

    def _place_again(self, _: object) -> None:
        self._to_place = True

    @property
    def choice(self) -> tuple[str, str]:
        """Where it looks from, one of VIEWS, and the name of the aircraft that it looks at."""
        first = self._names[0] if self._names else ""
        return self._view.value, first if self._chosen is None else self._chosen.value

    def show(self, names: tuple[str, ...], seen: Mapping[str, Watched], past: Frame | None) -> None:
        """Follow what is followed.

        Args:
            names: Of all aircraft that are seen now.
            seen: Those that this page sees, by name.
            past: Node under which the scene hangs where this page looks back.
        """
        if names != self._names:
            self._offer(names)
        view, name = self.choice
        if name not in seen:
            return
        flight, sight = seen[name]
        if not finite(sight.position, sight.heading, sight.path_angle):
            return
        world = self.world if past is None else past
        moved = scene_pose(view, sight)
        if view == ORBIT:
            moved = rigid.SE3.from_rotation(rigid.SO3.from_z_radians(self._opening_turn())) @ moved
        self._show_own(own_node(f"{world.name}/{name}"), view != COCKPIT)
        world.position, world.wxyz = moved.translation(), moved.rotation().wxyz
        camera = self._client.camera
        share = covered(self.width, camera.aspect)
        if self._to_place or (view == VIEWS[0] and self._is_outdated(sight, share)):
            self._to_place, self._aspect, self._covered = False, camera.aspect, share
            self._orbit_known = sight.wanted is not None
            pose = first_pose(view, (flight, sight), camera.aspect, share)
            self._placed = pose.position
            camera.position, camera.look_at = pose

    def _opening_turn(self) -> float:
        """How far the scene is turned in the first seconds in [rad]; it comes to rest smoothly."""
        now = time.monotonic()
        self._began = now if self._began is None else self._began
        left = max(1.0 - (now - self._began) / OPENING, 0.0) if OPENING > 0.0 else 0.0
        return OPENING_TURN * left**3

    def _show_own(self, node: str, visible: bool) -> None:
        """Hide what goes with the aircraft that this page sits in."""
        if not visible and node not in self._own:
            self._own[node] = self._client.scene.add_frame(node, show_axes=False)
        for own, frame in self._own.items():
            frame.visible = visible or own != node

    def _is_outdated(self, sight: Sight, share: float) -> bool:
        """Whether the view is for another shape, or for no orbit, and no hand has moved it.

        Args:
            sight: Of the aircraft that is looked at.
            share: That the legend covers [-].
        """
        camera = self._client.camera
        change = abs(camera.aspect - self._aspect) + abs(share - self._covered)
        reshaped = not change < RESHAPED
        found = sight.wanted is not None and not self._orbit_known
        return (reshaped or found) and any(
            np.allclose(camera.position, place, atol=1.0) for place in (self._placed, *self._firsts)
        )

    def _offer(self, names: tuple[str, ...]) -> None:
        self._names = names
        if self._chosen is not None:
            self._chosen.options = names
        elif len(names) > 1:
            self._chosen = self._client.gui.add_dropdown("of", names, order=-1.0)


class FirstView:
    """What a new page and the button that resets the view show.

    Args:
        server: Of the pages.

    Attributes:
        places: Of its cameras so far, newest last.
    """

    def __init__(self, server: viser.ViserServer) -> None:
        self._camera = server.initial_camera
        self._camera.fov, self._camera.near, self._camera.far = FIELD_OF_VIEW, NEAR, FAR
        self.places: deque[NDArray[np.float64]] = deque(maxlen=LAST_FIRST)

    def show(self, watched: Watched) -> None:
        """Look at an aircraft, anew where it has gone far.

        Args:
            watched: The aircraft that is seen first.
        """
        flight, sight = watched
        if not finite(sight.position):
            return
        pose = first_pose(VIEWS[0], watched, 1.0)
        gone = np.linalg.norm(pose.position - self.places[-1]) if self.places else math.inf
        if gone >= extent(flight, sight):
            self.places.append(pose.position)
            self._camera.position, self._camera.look_at = pose
