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

"""Every limit by its base: what a bound says, and that all its sides agree."""

import casadi as ca
import numpy as np
import pytest

from uav_tracking_mpc.limits import LIMIT, Ball, Bound, Cylinder, Floor, Limit, Motion
from uav_tracking_mpc.limits.envelope import Envelope
from uav_tracking_mpc.parameters.specification import ParameterError

LIMITS = {limit.name: limit for limit in Envelope(fence_radius=500.0, height_min=10.0).limits}
TARGETS = np.array([[0.0, 0.0, 0.0], [30.0, -10.0, 5.0], [60.0, -20.0, 10.0]])
MOTION = Motion(
    120.0, -40.0, 35.0, 0.1, 15.0, turn_rate=0.2, acceleration=0.3, turn_acceleration=-0.4
)


@pytest.mark.parametrize("name", LIMIT.own_names)
def test_numbers_follow_the_target_where_the_limit_is_on_the_ground(name):
    limit = LIMITS[name]
    numbers = limit.numbers(TARGETS)
    assert np.array_equal(numbers, np.tile(numbers[0], (3, 1))) is not limit.on_ground


@pytest.mark.parametrize("name", LIMIT.own_names)
def test_inputs_are_limited_by_symbols_as_by_numbers(name):
    limit = LIMITS[name]
    told = limit.numbers(TARGETS)[1]
    numeric = limit.inputs(MOTION, told, np)
    for key, (_, upper) in limit.inputs(MOTION, ca.DM(told), ca).items():
        assert float(upper) == pytest.approx(float(numeric[key][1]), rel=1e-14)


def test_a_bound_is_passed_beyond_one_percent_of_itself():
    bound = Bound(np.array([0.98, 0.995, 1.5, 2.01, 2.03, np.nan]), 1.0, 2.0, scale=0.5)
    assert bound.passed().tolist() == [True, False, False, False, True, True]
    below, above = bound.inequalities()
    np.testing.assert_allclose(below[:2], [0.04, 0.01])
    np.testing.assert_allclose(above[4], 0.06)


def test_a_limit_that_says_nothing_limits_nothing():
    class Nothing(Limit):
        name = "nothing"

    limit = Nothing()
    assert limit.numbers(TARGETS).shape == (3, 0)
    assert limit.stage(MOTION, [], np) is limit.orbit(None, [], np) is None
    assert limit.inputs(MOTION, [], np) == {} and limit.refusal(None, np.zeros(3)) == ""


def test_height_and_fence_move_as_the_target_does():
    """Both are fixed to the ground: seen from the target they move against it."""
    np.testing.assert_allclose(LIMITS["height"].numbers(TARGETS)[:, 0], 10.0 - TARGETS[:, 2])
    np.testing.assert_allclose(LIMITS["fence"].numbers(TARGETS)[:, :2], -TARGETS[:, :2])


def test_a_bank_limits_the_turn_by_the_airspeed():
    bank = LIMITS["bank"]
    turn = bank.turn_rate_max(15.0)
    assert np.tan(bank.bank_max) == pytest.approx(15.0 * turn / 9.80665)
    flown = bank.flown(MOTION._replace(turn_rate=turn), [])
    assert float(flown.value) == pytest.approx(bank.bank_max)


def test_the_roll_rate_is_that_of_the_bank_of_a_coordinated_turn():
    """Against a difference of banks; where the change of the turn is not known nothing is said."""
    limit, step = LIMITS["roll_rate"], 1e-6
    bound = limit.stage(MOTION, limit.numbers(TARGETS)[0], np)
    times = np.array([0.0, step])
    banks = np.arctan((15.0 + 0.3 * times) * (0.2 - 0.4 * times) / 9.80665)
    assert bound.value == pytest.approx(np.diff(banks)[0] / step, rel=1e-4)
    assert -bound.lower == bound.upper == limit.roll_rate_max
    assert limit.flown(MOTION._replace(turn_acceleration=None), [1.0]) is None


def test_a_bank_is_bounded_where_it_will_be_half_a_second_on():
    """Against a difference of banks; a turn whose change is not known is bounded by its input."""
    limit, step = LIMITS["bank"], 1e-6
    bound = limit.stage(MOTION, limit.numbers(TARGETS)[0], np)
    times = np.array([0.0, step])
    banks = np.arctan((15.0 + 0.3 * times) * (0.2 - 0.4 * times) / 9.80665)
    assert bound.value == pytest.approx(banks[0] + 0.5 * np.diff(banks)[0] / step, rel=1e-4)
    planned = np.arctan(0.98 * np.tan(limit.bank_max))
    assert -bound.lower == bound.upper == pytest.approx(planned)
    assert limit.stage(MOTION._replace(turn_acceleration=None), [1.0], np) is None


def test_the_force_of_a_climb_is_that_of_the_weight_along_the_path():
    flown = LIMITS["force"].flown(MOTION, [])
    assert float(flown.value) == pytest.approx(9.80665 * np.sin(0.1) + 0.3)


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"airspeed_min": 20.0, "airspeed_max": 15.0}, "'airspeed_max' is 15, must be above"),
        ({"force_min": (1.0, 1.0), "force_max": (2.0, 0.5)}, "'force_max' .*at both airspeeds"),
        ({"bank_max": 2.0}, "'bank_max' is 2.0, must be a number from 0.01 to 1.5 rad"),
        ({"fence_centre": (1.0, np.inf)}, "'fence_centre' is"),
    ],
)
def test_values_that_are_not_allowed_are_refused_in_words(values, words):
    with pytest.raises(ParameterError, match=words):
        Envelope(**values)


def test_a_parameter_that_no_limit_has_is_refused():
    with pytest.raises(TypeError, match="no limit has the parameters wingspan"):
        Envelope(wingspan=3.0)


def test_limits_that_have_a_place_say_where():
    """Those that are off, and those of the aircraft itself, have none."""
    envelope = Envelope(fence_radius=500.0, fence_centre=(3.0, 4.0), height_min=10.0)
    shapes = {limit.name: limit.shapes for limit in envelope.limits if limit.shapes}
    assert shapes == {
        "fence": (Cylinder(3.0, 4.0, 500.0, outside=False),),
        "height": (Floor(10.0),),
    }
    assert [shape for limit in Envelope(distance_min=60.0).limits for shape in limit.shapes] == [
        Ball(60.0)
    ]
