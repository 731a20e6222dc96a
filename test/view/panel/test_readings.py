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

import math

import numpy as np
import pytest
from watched_flight_stand_in import sight

from uav_tracking_mpc.settings.configuration import load_configuration
from uav_tracking_mpc.view.panel.readings import Readings, readings

SMALL, PAPER = (load_configuration(name).controller for name in ("small_uav", "paper"))


def reading(name, tracking=SMALL, **more):
    (found,) = (one for one in readings(sight(**more), tracking) if one.name == name)
    return found


def test_values_and_errors_are_shown(panel):
    text = panel(Readings).show()
    for words in ("300.4 m", "+0.4", "121.0 m", "+1.0", "22.5 m/s", "+0.5", "-11.5 °", "2.9 °"):
        assert words in text


def test_limits_are_those_of_the_controller():
    bank, climb = reading("Bank"), reading("Path angle")
    assert (bank.least, bank.most) == pytest.approx((-45.0, 45.0))
    assert (climb.least, climb.most) == pytest.approx((-9.0, 14.0))
    assert (reading("Airspeed").least, reading("Airspeed").most) == (14.0, 32.0)
    assert (reading("Range").least, reading("Altitude").least) == (60.0, 30.0)


def test_the_floor_is_told_from_the_target():
    assert reading("Altitude", target=replaced_target(up=25.0)).least == 5.0


def replaced_target(up):
    target = sight().target
    return type(target)(np.array([0.0, 0.0, up]))


def test_a_limit_as_wide_as_is_allowed_is_none():
    assert reading("Range", PAPER).least == reading("Altitude", PAPER).least == -math.inf


@pytest.mark.parametrize(
    ("degrees", "mark"),
    [(30.0, ""), (-44.0, "at limit"), (44.0, "at limit"), (46.0, "beyond limit")],
)
def test_a_value_is_marked_where_it_meets_a_limit(degrees, mark, panel, flight):
    assert reading("Bank", bank=math.radians(degrees)).mark == mark
    flight.seen = [sight(bank=math.radians(degrees))]
    text = panel(Readings).show()
    assert ("limit" in text.replace("limits", "")) == bool(mark)
    assert mark in text


def test_what_is_not_known_is_a_dash(panel, flight):
    flight.seen = [sight(airspeed=math.nan, bank=math.inf, target=None, errors={})]
    text = panel(Readings).show()
    assert "nan" not in text
    assert "inf" not in text
    assert text.count("–") >= 7  # noqa: RUF001
