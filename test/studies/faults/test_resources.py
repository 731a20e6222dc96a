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

import os

import pytest

from uav_tracking_mpc.studies.faults.resources import WARM_UP, Growth, Usage, usage


def watched(rss=lambda time: 10**8, handles=lambda time: 10, threads=lambda time: 5, seconds=300):
    growth = Growth(start=0.0)
    for time in range(seconds):
        growth.add(float(time), Usage(rss(time), handles(time), threads(time)))
    return growth


@pytest.mark.skipif(not os.path.isdir("/proc/self/fd"), reason="no /proc")
def test_usage_of_this_process():
    found = usage(os.getpid())
    assert found.rss > 1e6
    assert found.handles >= 3
    assert found.threads >= 1


def test_a_process_that_is_gone_uses_nothing():
    assert usage(2**22 + 1) is None


def test_a_leak_is_told_in_percent_an_hour_once_enough_was_watched():
    growth = watched(lambda time: round(100e6 + 100e6 * time / 3600.0))
    assert growth.rss_percent_per_hour() == pytest.approx(100.0, rel=0.01)
    assert watched(lambda time: 10**8, seconds=20).rss_percent_per_hour() is None


@pytest.mark.parametrize(
    ("use", "complaint"),
    [
        ({"rss": lambda time: round(100e6 + 100e6 * time / 3600.0)}, "memory grew by 7."),
        ({"rss": lambda time: 10**8 if time > WARM_UP - 1 else 10**7}, ""),  # loading is no leak
        ({"handles": lambda time: 10 + time // 10}, "handles grew from 11"),
        ({"threads": lambda time: 5 + time // 30}, "threads grew"),
        ({"handles": lambda time: 10 + 40 * (time % 3)}, ""),  # they come and go
    ],
)
def test_what_grows_and_stays_is_complained_of(use, complaint):
    words = watched(**use).complaint()
    assert complaint in words if complaint else words == ""
