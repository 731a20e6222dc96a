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

"""The aircraft as it banks and pitches, its place on the ground, ghosts of laws flown beside."""

from __future__ import annotations

import math

import numpy as np
import viser

from uav_tracking_mpc.control.fallback import FallbackMode
from uav_tracking_mpc.dynamics.frames import quaternion_from_euler
from uav_tracking_mpc.report.mode_colours import mode_colour, mode_words
from uav_tracking_mpc.view.scene import (
    GREY,
    Colour,
    Mesh,
    SceneElement,
    extent,
    finite,
    ground_height,
    joined,
    plate,
    ring,
    turned,
)
from uav_tracking_mpc.view.watched_flight import RivalSight, Sight

SHARE = 0.1  # length of the aircraft by the radius of its orbit: seen from where all of that is


def fuselage() -> Mesh:
    """Fuselage and fin in ``base_link``, 1 from nose to tail."""
    body = turned(
        [(0.5, 0.0), (0.46, 0.03), (0.3, 0.06), (0.05, 0.065), (-0.25, 0.035), (-0.5, 0.015)]
    )
    fin = plate(
        [(-0.34, 0, 0.02), (-0.46, 0, 0.22), (-0.53, 0, 0.22), (-0.5, 0, 0.02)], (0, 0.02, 0)
    )
    return joined(body, fin)


def wings() -> Mesh:
    """Wings and tailplane in ``base_link``; the left wing tip is the point of greatest y."""
    surfaces = []
    for side in (1.0, -1.0):
        wing = [(0.16, 0, 0.05), (0.07, 0.75 * side, 0.1), (-0.05, 0.75 * side, 0.1)]
        tail = [(-0.37, 0, 0.02), (-0.42, 0.26 * side, 0.02), (-0.5, 0.26 * side, 0.02)]
        surfaces.append(plate([*wing, (-0.12, 0, 0.05)], (0, 0, 0.025)))
        surfaces.append(plate([*tail, (-0.5, 0, 0.02)], (0, 0, 0.015)))
    return joined(*surfaces)


def attitude(sight: Sight) -> tuple[float, float, float, float]:
    """Of ``base_link`` in ``map``, quaternion w, x, y, z; a bank that is not known counts as none.

    Args:
        sight: Of this aircraft.
    """
    bank = sight.bank if math.isfinite(sight.bank) else 0.0
    return quaternion_from_euler(bank, -sight.path_angle, sight.heading)


def caption(name: str, mode: FallbackMode | None) -> str:
    """What stands above the aircraft: its name, and what is flown unless that is as asked for.

    Args:
        name: Of the aircraft.
        mode: None before the first command.
    """
    name = name.replace("_", " ")  # a label cuts off what reaches below its line
    as_asked = mode is not None and mode.nominal
    return name if as_asked else f"{name}: {mode_words(mode)}"


class Airframe(SceneElement):
    """Fuselage in the colour of the aircraft, wings in that of the mode, and a name."""

    name = "airframe"

    def add(self) -> None:
        """Send the meshes."""
        self._place = self.scene.add_frame(
            self.at_aircraft.rpartition("/")[0], show_axes=False, visible=False
        )
        self._body = self.scene.add_frame(f"{self.at_aircraft}/body", show_axes=False)
        self._fuselage = self.scene.add_mesh_simple(
            f"{self.at_aircraft}/body/fuselage", *fuselage(), color=self.colour, side="double"
        )
        self._wings = self.scene.add_mesh_simple(
            f"{self.at_aircraft}/body/wings",
            *wings(),
            color=mode_colour(None),
            flat_shading=True,
            side="double",
        )
        self._label = self.scene.add_label(
            f"{self.at_aircraft}/label", caption(self.flight.name, None), anchor="bottom-center"
        )

    def show(self, sight: Sight) -> None:
        """Move and turn it.

        Args:
            sight: Of this aircraft.
        """
        self._place.visible = finite(sight.position, sight.heading, sight.path_angle)
        if not self._place.visible:
            return
        size = SHARE * extent(self.flight, sight)
        self._place.position, self._body.wxyz = sight.position, attitude(sight)
        self._fuselage.scale = self._wings.scale = size
        self._wings.color = mode_colour(sight.mode)
        self._label.position = (0.0, 0.0, 0.5 * size)
        self._label.text = caption(self.flight.name, sight.mode)


RING = 0.02  # radius of the ring by that of the orbit
STEP = 0.002  # least change of the height, by the radius of the orbit, that is drawn
SHADOW: Colour = (20, 24, 28)


class DropLine(SceneElement):
    """A line down to the shadow; both hang under the aircraft: only changes of height are sent."""

    name = "drop_line"

    def add(self) -> None:
        """Send the line, 1 long, and the shadow."""
        line = np.array([[[0.0, 0.0, 0.0], [0.0, 0.0, -1.0]]])
        points, self._drawn = np.concatenate([line, ring() - [0.0, 0.0, 1.0]]), math.nan
        self._line = self.add_lines(f"{self.at_aircraft}/drop_line", points, GREY, 1.5, True)
        points, faces = joined(fuselage(), wings())
        self._shadow = self.scene.add_mesh_simple(
            f"{self.at_aircraft}/shadow",
            points * [1.0, 1.0, 0.0],
            faces,
            color=SHADOW,
            opacity=0.35,
            side="double",
        )

    def show(self, sight: Sight) -> None:
        """Give it the length of now.

        Args:
            sight: Of this aircraft.
        """
        size, height = extent(self.flight, sight), float(sight.position[2]) - ground_height(sight)
        if not finite(height, sight.heading):
            return
        self._shadow.wxyz = quaternion_from_euler(0.0, 0.0, sight.heading)
        if abs(height - self._drawn) < STEP * size:
            return
        self._drawn = height
        self._line.scale = (RING * size, RING * size, height)
        self._shadow.scale, self._shadow.position = SHARE * size, (0.0, 0.0, STEP * size - height)


APART = 0.7  # by the length of an aircraft: height of one's words over another's
RIVAL: Colour = (110, 110, 120)


def rival_caption(rival: RivalSight) -> str:
    """What stands above a ghost.

    Args:
        rival: As it is seen.
    """
    return f"{rival.law}: {rival.range_error:+.1f} m"


class Rivals(SceneElement):
    """A translucent aircraft for each."""

    name = "rivals"

    def add(self) -> None:
        """Begin with none: they are asked for."""
        self._ghosts: dict[str, tuple[viser.MeshHandle, viser.LabelHandle]] = {}

    def show(self, sight: Sight) -> None:
        """Move those that fly, and hide the others.

        Args:
            sight: Of this aircraft.
        """
        size = SHARE * extent(self.flight, sight)
        seen = {
            rival.law: rival
            for rival in sight.rivals
            if finite(rival.position, rival.heading, rival.path_angle, rival.bank)
        }
        for law, (body, label) in self._ghosts.items():
            body.visible = label.visible = law in seen
        for rank, (law, rival) in enumerate(seen.items(), 1):
            body, label = self._ghosts.get(law) or self._add(law)
            body.position, body.scale = rival.position, size
            body.wxyz = quaternion_from_euler(rival.bank, -rival.path_angle, rival.heading)
            # Words at heights of their own: where all fly well they fly at one place.
            label.position = np.add(rival.position, (0.0, 0.0, (0.5 + APART * rank) * size))
            label.text = rival_caption(rival)

    def _add(self, law: str) -> tuple[viser.MeshHandle, viser.LabelHandle]:
        place = f"{self.root}/rivals/{law}"
        body = self.scene.add_mesh_simple(
            f"{place}/body", *joined(fuselage(), wings()), color=RIVAL, opacity=0.55, side="double"
        )
        label = self.scene.add_label(f"{place}/label", "", anchor="bottom-center")
        self._ghosts[law] = body, label
        return body, label
