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

"""Noise that is drawn is recognised, and made white."""

import numpy as np
from scipy.signal import lfilter

from uav_tracking_mpc.studies.identification.noise_model import noise_of


def test_white_noise_stays_as_it_is():
    noise = noise_of(0.3 * np.random.default_rng(0).standard_normal(2000), 1e-3)
    np.testing.assert_array_equal(noise.polynomial, [1.0])
    assert abs(noise.deviation - 0.3) < 0.02


def test_coloured_noise_is_made_white():
    drawn = 0.1 * np.random.default_rng(1).standard_normal(4000)
    coloured = lfilter([1.0], [1.0, -1.5, 0.7], drawn)
    noise = noise_of(coloured, 1e-3)
    white = noise.whitened(coloured)
    assert abs(noise.deviation - 0.1) < 0.01
    assert abs(np.std(white) - 1.0) < 0.05
    assert abs(white[1:] @ white[:-1]) / len(white) < 0.05


def test_no_sensor_is_exact():
    assert noise_of(np.zeros(100), 0.01).deviation == 0.01
