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


def watched(rss, handles=lambda time: 10, threads=lambda time: 5, seconds=300):
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


def test_a_leak_is_told_in_percent_an_hour():
    growth = watched(lambda time: round(100e6 + 100e6 * time / 3600.0))
    assert growth.rss_percent_per_hour() == pytest.approx(100.0, rel=0.01)
    assert "memory grew by 7." in growth.complaint()


def test_loading_is_no_leak():
    growth = watched(lambda time: 100_000_000 if time > WARM_UP - 1 else 10_000_000)
    assert growth.rss_percent_per_hour() == pytest.approx(0.0, abs=1e-6)
    assert growth.complaint() == ""


def test_a_short_life_tells_nothing():
    assert watched(lambda time: 10**8, seconds=20).rss_percent_per_hour() is None


def test_handles_and_threads_that_stay_are_complained_of():
    assert (
        "handles grew from 11"
        in watched(lambda time: 10**8, handles=lambda time: 10 + time // 10).complaint()
    )
    assert (
        "threads grew"
        in watched(lambda time: 10**8, threads=lambda time: 5 + time // 30).complaint()
    )


def test_handles_that_come_and_go_are_no_leak():
    assert watched(lambda time: 10**8, handles=lambda time: 10 + 40 * (time % 3)).complaint() == ""
