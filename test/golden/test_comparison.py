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

import pytest
from golden.comparison import MISSING, amplified, differences

RECORD = {
    "flight digest": "ab",
    "modes": [{"from [s]": 0.0, "mode": "optimal plan"}],
    "every 2 s": {"x [m]": [600.0, 560.0, "NaN"], "heading [rad]": [3.1, -3.14, 0.0]},
    "range_rms_m": 0.5,
    "missed": None,
    "median_us": 70.0,
    "sent": 80,
}


def only(found, recorded=RECORD):
    (difference,) = differences(recorded, found)
    return difference


def test_equal_is_silent():
    assert not list(differences(RECORD, dict(reversed(RECORD.items()))))


def test_a_number_beyond_its_tolerance_is_named_with_values():
    found = {**RECORD, "every 2 s": {**RECORD["every 2 s"], "x [m]": [600.0, 560.5, "NaN"]}}
    difference = only(found)
    assert difference.place == ("every 2 s", "x [m]", 1)
    assert difference.size > 1.0
    assert "every 2 s/x [m]/at 2 s: recorded 560.0, now 560.5 (by 0.5," in str(difference)


def test_the_last_bit_is_a_difference_within_tolerance():
    assert 0.0 < only({**RECORD, "range_rms_m": math.nextafter(0.5, 1.0)}).size < 1e-6


def test_angles_differ_by_the_short_way_round():
    headings = [3.1, 3.14, 0.0]  # on the other side of the cut, 3.2e-3 rad away
    found = {**RECORD, "every 2 s": {**RECORD["every 2 s"], "heading [rad]": headings}}
    difference = only(found)
    assert difference.quantity == "angle"
    assert difference.size == pytest.approx((2.0 * math.pi - 6.28) / 1e-8)


def test_where_jsbsim_flies_the_tolerances_are_its_own():
    flown, now = {"x [m]": 600.0}, {"x [m]": 600.1}
    assert only({"small_uav: mission: nmpc": now}, {"small_uav: mission: nmpc": flown}).size > 1.0
    assert only({"jsbsim_uav: mission: nmpc": now}, {"jsbsim_uav: mission: nmpc": flown}).size < 1.0


def test_missing_and_new_keys_and_items_are_named():
    less = {name: value for name, value in RECORD.items() if name != "flight digest"}
    assert only(less).found is MISSING
    assert only(RECORD, less).recorded is MISSING
    assert only({**RECORD, "modes": []}).place == ("modes", 0)
    assert only({**RECORD, "modes": [*RECORD["modes"], {}]}).place == ("modes", 1)
    assert math.isinf(only(less).size) and math.isinf(only({**RECORD, "modes": []}).size)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("sent", 81),
        ("missed", 0.0),
        ("sent", True),
        ("range_rms_m", "NaN"),
        ("range_rms_m", math.nan),
        ("median_us", None),
        ("modes", [{"from [s]": 0.0, "mode": "loiter law"}]),
    ],
)
def test_counts_texts_and_kinds_are_exact(name, value):
    assert only({**RECORD, name: value}).size > 1.0


def test_wall_time_is_not_compared():
    assert not list(differences(RECORD, {**RECORD, "median_us": 900.0}))


def test_a_digest_alone_tells_another_bit_and_no_other_behaviour():
    assert only({**RECORD, "flight digest": "cd"}).size == 0.0


def test_what_the_least_other_begin_changes_as_much_is_no_other_behaviour():
    now, twin = {**RECORD, "range_rms_m": 0.7, "sent": 81}, {**RECORD, "range_rms_m": 0.8}
    beyond = list(differences(RECORD, now))
    assert {each.place for each in beyond} == {("range_rms_m",), ("sent",)}
    assert [each.place for each in amplified(beyond, now, [now, {**twin, "sent": 81}])] == [
        ("sent",)
    ]
    assert not amplified(beyond, now, [twin])
    assert len(amplified(beyond, now, [now])) == 2
