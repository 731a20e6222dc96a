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

"""What is flown: a law whose bank alone is free, and the nearer way round."""

import math

import numpy as np
import pytest
import small_uav
from hypothesis import given
from hypothesis import strategies as st

from uav_tracking_mpc.control.controller import Controller
from uav_tracking_mpc.control.guidance import HYSTERESIS, law_about, law_inputs, nearest_direction
from uav_tracking_mpc.dynamics.orbit import CLOCKWISE, COUNTER_CLOCKWISE, DIRECTIONS
from uav_tracking_mpc.estimation.navigator import Navigator
from uav_tracking_mpc.estimation.situation import Situation
from uav_tracking_mpc.laws import GuidanceLaw
from uav_tracking_mpc.laws.vector_field import VectorField
from uav_tracking_mpc.parameters.specification import ParameterError

angles = st.floats(-math.pi, math.pi)


def situation(azimuth, course, distance=300.0, drift=(0.0, 0.0, 0.0)):
    """Relative velocity of 22 m/s along ``course``, at ``distance`` from the target."""
    air = 22.0 * np.array([math.cos(course), math.sin(course)]) - np.array(drift[:2])
    vehicle = np.array(
        [
            distance * math.cos(azimuth),
            distance * math.sin(azimuth),
            120.0,
            math.atan2(air[1], air[0]),
            0.0,
            math.hypot(*air),
        ]
    )
    return Situation(vehicle, np.zeros(3), np.array(drift), np.zeros(3), np.zeros(3))


def other(direction):
    return COUNTER_CLOCKWISE if direction == CLOCKWISE else CLOCKWISE


@given(angles, st.floats(0.01, math.pi - 0.01), st.tuples(*[st.floats(-15.0, 15.0)] * 3))
def test_the_nearer_one_is_that_of_the_relative_motion(azimuth, angle, drift):
    """In any drift: the air velocity may point elsewhere."""
    left = nearest_direction(situation(azimuth, azimuth + angle, drift=drift))
    right = nearest_direction(situation(azimuth, azimuth - angle, drift=drift))
    assert (left, right) == (COUNTER_CLOCKWISE, CLOCKWISE)


@pytest.mark.parametrize("present", DIRECTIONS)
@given(azimuth=angles, off=st.floats(-math.pi, math.pi))
def test_a_choice_is_left_only_by_a_flight_clearly_against_it(present, azimuth, off):
    sense = 1.0 if present == COUNTER_CLOCKWISE else -1.0
    tangent = azimuth + sense * math.pi / 2.0
    limit = math.pi / 2.0 + HYSTERESIS
    if abs(abs(off) - limit) > 1e-6:
        chosen = nearest_direction(situation(azimuth, tangent + off), present)
        assert chosen == (present if abs(off) < limit else other(present))


@given(st.sampled_from(DIRECTIONS), angles, angles)
def test_what_has_been_chosen_anew_is_kept_in_the_same_situation(present, azimuth, course):
    """No flight makes it change its mind twice."""
    now = situation(azimuth, course)
    chosen = nearest_direction(now, present)
    assert nearest_direction(now, chosen) == chosen
    first = nearest_direction(now)
    assert nearest_direction(now, first) == first


@pytest.mark.filterwarnings("ignore:invalid value:RuntimeWarning")
@pytest.mark.parametrize("present", DIRECTIONS)
@pytest.mark.parametrize(
    ("x", "psi", "speed"),
    [(np.nan, 1.0, 22.0), (np.inf, 1.0, 22.0), (-np.inf, 1.0, 22.0), (300.0, np.nan, 22.0),
     (300.0, 1.0, np.inf), (300.0, 1.0, -np.inf)],
)  # fmt: skip
def test_a_situation_that_tells_nothing_changes_nothing(present, x, psi, speed):
    vehicle = np.array([x, 0.0, 0.0, psi, 0.0, speed])
    unknown = Situation(vehicle, np.zeros(3), np.zeros(3), np.zeros(3), np.zeros(3))
    assert nearest_direction(unknown) in DIRECTIONS
    assert nearest_direction(unknown, present) == present


@pytest.mark.parametrize("present", DIRECTIONS)
def test_above_the_target_the_choice_is_kept(present):
    assert nearest_direction(situation(0.3, 1.0, distance=0.0), present) == present


FREE = small_uav.parameters()
HELD = small_uav.parameters("autopilot_holds=true")
LOW = small_uav.situation(z=90.0, airspeed=20.0)


def test_the_turn_is_the_laws_and_the_rest_the_autopilots():
    free, held = (law_about(VectorField, p.orbit, p) for p in (FREE, HELD))
    assert isinstance(free, VectorField)
    assert held.name == free.name
    turn, climb, gain = held.inputs(LOW)
    assert turn == free.inputs(LOW)[0]
    model = HELD.vehicle
    state = model.initial(LOW.vehicle, LOW.target, LOW.rates)
    expected = model.held(state, 120.0, 22.0, model.numbers(0.4), LOW.drift)
    assert [climb, gain] == pytest.approx(expected)


class Broken(GuidanceLaw):
    name = "broken"

    def inputs(self, situation):
        return np.array([np.nan, 0.0, 0.0])


def test_a_law_that_fails_is_told_by_its_name():
    inputs, words = law_inputs(law_about(Broken, HELD.orbit, HELD), LOW)
    assert inputs is None
    assert "the law broken answered [nan" in words


TABULATED = """
from uav_tracking_mpc.laws.vector_field import VectorField

class Tabulated(VectorField):
    name = "tabulated"

    def __init__(self, orbit, envelope):
        super().__init__(orbit, envelope)
        if orbit.range > 400.0:
            raise KeyError("the table ends at 400 m")
"""


def test_a_law_that_cannot_be_made_for_an_orbit_refuses_it_as_a_whole(tmp_path):
    (tmp_path / "law.py").write_text(TABULATED)
    parameters = small_uav.parameters(f"law={tmp_path / 'law.py'}:Tabulated")
    controller = Controller(parameters)
    with pytest.raises(ParameterError, match="the law tabulated .*the table ends at 400 m"):
        controller.change(range=450.0, airspeed=24.0)
    assert controller.parameters is parameters
    assert (controller.orbit.range, controller.orbit.speed) == (300.0, 22.0)
    controller.change(range=350.0)


def test_where_the_nearest_direction_is_flown_a_law_must_fly_both(tmp_path):
    """It was asked about one alone, and ended the flight where the other one was nearer."""
    one_way = TABULATED.replace("orbit.range > 400.0", "orbit.sense > 0.0")
    (tmp_path / "law.py").write_text(one_way)
    law = f"law={tmp_path / 'law.py'}:Tabulated"
    with pytest.raises(ParameterError, match="the law tabulated cannot fly"):
        Controller(small_uav.parameters(law, "direction=nearest"))
    controller = Controller(small_uav.parameters(law, "direction=clockwise"))
    with pytest.raises(ParameterError, match="the law tabulated cannot fly"):
        controller.change(direction="nearest")


def test_a_law_that_refuses_the_orbit_off_an_airspeed_limit_goes_on_with_its_own(
    tmp_path, monkeypatch
):
    (tmp_path / "law.py").write_text(TABULATED.replace("orbit.range > 400.0", "orbit.speed > 16.0"))
    law = f"law={tmp_path / 'law.py'}:Tabulated"
    controller = Controller(small_uav.parameters(law, "airspeed=16.0"))
    unknown = property(lambda navigator: (3.0, (0.0, 0.0)))
    monkeypatch.setattr(Navigator, "airspeed_uncertainty", unknown)
    controller._keep_margin()
    assert controller.orbit.speed == controller._law.orbit.speed == 16.0
    assert controller.events.take()[-1].words.startswith("the orbit stays as it was: the law")


PICKY = """
from dataclasses import dataclass
from uav_tracking_mpc.limits.airspeed import AirspeedSpan

@dataclass(frozen=True)
class Picky(AirspeedSpan):
    name = "picky"

    def numbers(self, targets):
        if self.airspeed_min > 15.0:
            raise ZeroDivisionError("too picky")
        return super().numbers(targets)
"""


def test_a_limit_that_raises_off_an_airspeed_limit_leaves_the_orbit_as_it_is(tmp_path, monkeypatch):
    (tmp_path / "limit.py").write_text(PICKY)
    limit = f"limits={tmp_path / 'limit.py'}:Picky"
    controller = Controller(small_uav.parameters(limit, "airspeed=15.0", "solver=ipopt"))
    unknown = property(lambda navigator: (3.0, (0.0, 0.0)))
    monkeypatch.setattr(Navigator, "airspeed_uncertainty", unknown)
    controller._keep_margin()
    assert controller.orbit.speed == 15.0
    assert controller.events.take()[-1].words == "the orbit stays as it was: too picky"
