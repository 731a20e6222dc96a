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

"""Target and drift ahead, against the formulas evaluated one by one."""

import numpy as np
import pytest

from uav_tracking_mpc.estimation.outlook import FADE_TIME, Outlook
from uav_tracking_mpc.estimation.target_motion import REWIND, TURN

STATE = np.array([[10.0, -20.0, 3.0], [6.0, -2.0, 0.4], [0.8, 0.3, 0.0]])
WIND, GUST, TIMES = np.array([5.0, 2.0, 0.1]), np.array([1.0, -2.0, 0.5]), np.array([8.0, 8.0, 3.0])
TREND = np.array([0.1, -0.2, 0.0])
FADED = np.array([1.0, -0.5, 0.2, 0.3, 0.1, -0.1])
AHEAD = np.array([0.0, 0.2, 0.5, 3.0, 10.0])


def ahead(travelled=0.3, left=1.0, faded=FADED, turn_rate=0.2):
    track = 0.04, turn_rate, travelled, left
    air = WIND, TREND, GUST, TIMES
    return Outlook(len(AHEAD))(STATE.reshape(-1), track, faded, air, AHEAD)


@pytest.mark.parametrize(("travelled", "left"), [(0.3, 1.0), (6.0, 0.5), (0.0, 0.0)])
@pytest.mark.parametrize("turn_rate", [0.0, 0.2, -2.0])
def test_target_wind_gust_and_what_fades_add_up(travelled, left, turn_rate):
    target, drift, drift_rate = ahead(travelled, left, turn_rate=turn_rate)
    leads = travelled + left * AHEAD
    motions = [TURN(STATE.ravel(), 0.04, turn_rate, lead).full().reshape(3, 3) for lead in leads]
    p, v, a = np.swapaxes(motions, 0, 1)
    share = np.exp(-AHEAD / FADE_TIME)[:, np.newaxis]
    gust = np.exp(-AHEAD[:, np.newaxis] / TIMES) * GUST
    np.testing.assert_allclose(target, p + share * FADED[:3], atol=1e-9)
    expected = WIND + AHEAD[:, np.newaxis] * TREND + gust - left * v - share * FADED[3:]
    np.testing.assert_allclose(drift, expected, atol=1e-9)
    np.testing.assert_allclose(drift_rate, TREND - gust / TIMES - left**2 * a, atol=1e-9)


def test_a_track_is_not_followed_further_back_than_it_reaches():
    back = ahead(travelled=-5.0, left=0.0, faded=np.zeros(6))
    least = TURN(STATE.ravel(), 0.04, 0.2, -REWIND).full()[:3].ravel()
    np.testing.assert_allclose(back[0], np.tile(least, (len(AHEAD), 1)), atol=1e-9)


def test_a_later_call_leaves_an_earlier_answer_alone():
    outlook = Outlook(len(AHEAD))
    told = STATE.reshape(-1), (0.04, 0.2, 0.3, 1.0), FADED
    first = outlook(*told, (WIND, TREND, GUST, TIMES), AHEAD)
    kept = first[1].copy()
    outlook(*told, (-WIND, TREND, GUST, TIMES), AHEAD)
    np.testing.assert_array_equal(first[1], kept)
