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

import numpy as np
import pytest

from uav_tracking_mpc.control.pace import Pace


@pytest.mark.parametrize(
    ("rate", "expected"), [(10.0, 10.0), (15.0, 15.0), (8.0, 8.0), (20.0, 20.0), (50.0, 20.0)]
)
def test_commands_keep_their_rate_on_the_average_up_to_that_of_the_states(rate, expected):
    """States at 20 Hz for 60 s."""
    pace = Pace(rate)
    stamps = (np.arange(1200) * 0.05).tolist()
    assert sum(pace.due(stamp) for stamp in stamps) == pytest.approx(expected * 60, abs=2)


def test_lost_time_is_not_caught_up_with():
    pace = Pace(10.0)
    assert pace.due(0.0)
    assert pace.due(5.0)
    assert not pace.due(5.05)
    assert pace.due(5.1)


def test_where_time_went_back_the_next_state_is_due():
    pace = Pace(1.0)
    pace.due(10.0)
    assert pace.due(0.0)


def test_another_rate_counts_from_the_command_before():
    pace = Pace(1.0)
    assert pace.due(10.0)
    pace.period = 0.1
    assert not pace.due(10.05)
    assert pace.due(10.1)
