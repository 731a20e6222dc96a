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

"""All elements together: what did not change is not sent, what is not finite is not drawn."""

import dataclasses
import math

import numpy as np
import pytest
from watched_flight_stand_in import StandInFlight, StandInSteering, sight

from uav_tracking_mpc.control.fallback import FallbackMode
from uav_tracking_mpc.dynamics.orbit import FlownOrbit
from uav_tracking_mpc.view.scene import SCENE_ELEMENT
from uav_tracking_mpc.view.watched_flight import TargetSight

ORBIT = FlownOrbit(np.array([0.0, 0.0, 120.0]), np.zeros(3), -275.0, 22.0)
FULL = sight(
    wanted=ORBIT,
    flown=ORBIT._replace(radius=-300.0),
    wind=np.array([4.0, 1.0, 0.0]),
    plan=np.array([[275.0, 0.0, 121.0], [274.0, -9.0, 121.0]]),
    target=TargetSight(
        np.zeros(3),
        np.array([3.0, 0.0, 0.0]),
        1.0,
        np.ones(3),
        np.full(3, 5.0),
        np.array([[0.0, 0.0, 0.0, 1.0], [3.0, 0.0, 0.0, 1.5]]),
    ),
)


@pytest.fixture
def elements(scene):
    flight = StandInFlight(steering=StandInSteering())
    colour = (0, 114, 178)
    return [kind(scene, "/world/a", flight, colour) for kind in SCENE_ELEMENT.all().values()]


def show(elements, seen):
    for element in elements:
        element.show(seen)


def test_nothing_is_sent_when_nothing_changed(elements, sent):
    show(elements, FULL)
    assert sent
    sent.clear()
    for _ in range(3):
        show(elements, dataclasses.replace(FULL))
    assert sent == []


def numbers(message):
    """Every number that a message carries."""
    for value in vars(message).values():
        inner = vars(value).values() if dataclasses.is_dataclass(value) else [value]
        for part in inner:
            for each in part.values() if isinstance(part, dict) else [part]:
                if isinstance(each, (float, tuple, np.ndarray)):
                    array = np.asarray(each)
                    if array.dtype.kind == "f":
                        yield array


NAN = np.full(3, math.nan)
BAD = {
    "position": NAN,
    "heading": math.nan,
    "path_angle": math.inf,
    "bank": math.nan,
    "airspeed": math.nan,
    "ground_velocity": NAN,
    "wind": NAN,
    "plan": np.full((2, 3), math.nan),
    "wanted": ORBIT._replace(centre=NAN, radius=math.nan),
    "flown": ORBIT._replace(radius=math.inf),
    "target": TargetSight(NAN, NAN, math.nan, NAN, NAN, np.full((2, 4), math.nan)),
    "time": math.nan,
}


@pytest.mark.parametrize("what", [*BAD, "all"])
def test_what_is_not_finite_is_not_drawn(elements, sent, what):
    bad = BAD if what == "all" else {what: BAD[what]}
    seen = dataclasses.replace(FULL, **bad)
    show(elements, seen)
    show(elements, FULL)
    show(elements, seen)
    assert all(np.isfinite(array).all() for message in sent for array in numbers(message))


def test_before_the_target_is_known_only_the_aircraft_is_seen(elements, scene):
    show(elements, sight(target=None, mode=None))
    assert scene.get_handle_by_name("/world/a/aircraft").visible
    for name in ("target", "wind", "orbits/wanted", "orbits/flown", "plan/line", "target_ghost"):
        assert not scene.get_handle_by_name(f"/world/a/{name}").visible


def test_a_change_of_mode_is_seen_on_wings_plan_and_orbit(elements, sent):
    show(elements, FULL)
    sent.clear()
    show(elements, dataclasses.replace(FULL, mode=FallbackMode.HOLD))
    changed = {message.name.rpartition("/")[2] for message in sent}
    assert changed == {"wings", "label", "flown", "line", "ghosts"}
