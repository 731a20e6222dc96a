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

from uav_tracking_mpc.estimation.measurement import SILENT
from uav_tracking_mpc.links.mavlink.accuracies import AGE, Accuracies
from uav_tracking_mpc.links.mavlink.dialect import mavlink


def estimator(level, vertical):
    return mavlink.MAVLink_estimator_status_message(0, 63, *([0.1] * 6), level, vertical)


def receiver(level, vertical, speed):
    """In [mm] and [mm/s]."""
    return mavlink.MAVLink_gps_raw_int_message(
        0, 3, 0, 0, 0, 80, 120, 0, 0, 12, h_acc=level, v_acc=vertical, vel_acc=speed
    )


def told(*messages, now=0.0):
    accuracies = Accuracies()
    for message in messages:
        accuracies.see(message, 0.0)
    return accuracies.noise(now)


def test_the_filter_counts_before_the_receiver():
    noise = told(estimator(0.5, 0.8), receiver(900, 1500, 200))
    assert noise.position == pytest.approx((0.5, 0.5, 0.8))
    assert noise.velocity == pytest.approx((0.2, 0.2, 0.2))
    assert told(receiver(900, 1500, 200)).position == pytest.approx((0.9, 0.9, 1.5))
    assert told(estimator(0.5, 0.8)).velocity == (0.0, 0.0, 0.0)


@pytest.mark.parametrize("wrong", [0.0, -1.0, math.nan, math.inf, 1e12])
def test_what_makes_no_sense_is_unknown(wrong):
    assert told(estimator(wrong, wrong)) is SILENT
    assert told(estimator(wrong, wrong), receiver(900, 1500, 0)).position[0] == pytest.approx(0.9)
    assert told(receiver(0, 0, 0)) is SILENT


def test_test_ratios_are_no_variances():
    assert told(mavlink.MAVLink_ekf_status_report_message(831, 0.1, 0.1, 0.1, 0.1, 0.1)) is SILENT


def test_what_is_old_counts_no_more():
    messages = estimator(0.5, 0.8), receiver(900, 1500, 200)
    assert told(*messages, now=AGE) is not SILENT
    assert told(*messages, now=AGE + 0.1) is SILENT
