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

"""A limit is found where the answer shows one, and else not."""

import pytest
from excited_channel import record

from uav_tracking_mpc.studies.identification.saturation import Limits, limited_fit


def test_a_limit_is_found_and_does_not_disturb_the_rest():
    fit, limits = limited_fit(record(0.3, 0.1, gain=0.8, noise=0.05, limit=0.8, slow=0.8))
    assert 0.8 * limits.upper == pytest.approx(0.8, abs=0.04)
    assert 0.8 * limits.lower == pytest.approx(-0.8, abs=0.04)
    assert fit.lag == pytest.approx(0.3, abs=0.03)


def test_without_a_limit_none_is_found():
    _, limits = limited_fit(record(0.3, 0.1, slow=0.8))
    assert limits == Limits()
