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

"""ArduPlane's parameters, by any of their names, as limits of the controller."""

import math

import pytest

from uav_tracking_mpc.links.mavlink.arduplane_envelope import BANK_KEPT, ArduPlaneEnvelope

NEW = {
    "ROLL_LIMIT_DEG": 45.0,
    "AIRSPEED_MIN": 12.0,
    "AIRSPEED_MAX": 28.0,
    "AIRSPEED_CRUISE": 20.0,
    "TECS_CLMB_MAX": 5.0,
    "TECS_SINK_MIN": 2.0,
    "TECS_SINK_MAX": 4.0,
    "TECS_TIME_CONST": 5.0,
    "RLL2SRV_RMAX": 60.0,
}
OLD = {
    "LIM_ROLL_CD": 4500.0,
    "ARSPD_FBW_MIN": 12.0,
    "ARSPD_FBW_MAX": 28.0,
    "TRIM_ARSPD_CM": 2000.0,
    **{name: NEW[name] for name in NEW if name.startswith(("TECS", "RLL"))},
}


def test_old_and_new_names_mean_the_same():
    new, old = ArduPlaneEnvelope(NEW, 1.05), ArduPlaneEnvelope(OLD, 1.05)
    assert new.values(20.0) == old.values(20.0)
    assert new.cruise == pytest.approx(old.cruise) == pytest.approx(21.0)


def test_the_values_are_those_of_the_vehicle():
    values = ArduPlaneEnvelope(NEW, 1.05).values(21.0)
    assert values["bank_max"] == pytest.approx(math.radians(45.0) - BANK_KEPT)
    assert (values["airspeed_min"], values["airspeed_max"]) == pytest.approx((12.6, 29.4))
    assert math.sin(values["path_angle_max"]) * 21.0 == pytest.approx(5.0)
    assert math.sin(values["path_angle_min"]) * 21.0 == pytest.approx(-4.0)
    assert values["roll_rate_max"] < math.radians(60.0)


@pytest.mark.parametrize(("airspeed", "bank"), [(13.0, 31.6), (15.0, 45.0), (12.0, 25.0)])
def test_near_the_stall_the_bank_is_less(airspeed, bank):
    envelope = ArduPlaneEnvelope(NEW, 1.0)
    assert math.degrees(envelope.bank_max(airspeed)) == pytest.approx(bank, abs=0.1)


def test_without_stall_prevention_the_limit_alone_counts():
    envelope = ArduPlaneEnvelope({**NEW, "STALL_PREVENTION": 0.0}, 1.0)
    assert math.degrees(envelope.bank_max(13.0)) == pytest.approx(45.0)


def test_what_cannot_be_read_is_not_made_up():
    envelope = ArduPlaneEnvelope({}, 1.0)
    assert envelope.values(20.0) == {}
    assert envelope.bank_max(20.0) is None
    assert envelope.cruise is None


def test_a_fence_has_the_kinds_that_are_switched_on():
    fence = {"FENCE_ENABLE": 1.0, "FENCE_ALT_MAX": 150.0, "FENCE_ALT_MIN": 20.0}
    fence["FENCE_RADIUS"] = 900.0
    circle = ArduPlaneEnvelope({**fence, "FENCE_TYPE": 2.0}, 1.0).fence()
    assert circle == (-math.inf, math.inf, pytest.approx(890.0))
    all_of_them = ArduPlaneEnvelope({**fence, "FENCE_TYPE": 11.0}, 1.0).fence()
    assert all_of_them == pytest.approx((30.0, 140.0, 890.0))
    assert ArduPlaneEnvelope({**fence, "FENCE_ENABLE": 0.0}, 1.0).fence() is None


def test_the_pilot_is_told_what_matters():
    doubtful = {"FENCE_ENABLE": 1.0, "FENCE_ACTION": 6.0, "STICK_MIXING": 1.0}
    doubtful.update({"SCHED_LOOP_RATE": 50.0, "GUIDED_TIMEOUT": 0.0})
    words = " ".join(ArduPlaneEnvelope(doubtful, 1.0).warnings(50.0))
    for name in ("FENCE_ACTION is 6", "STICK_MIXING", "comes at 40 Hz", "GUIDED_TIMEOUT is 0"):
        assert name in words
