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

pytest.importorskip("rclpy")

from uav_tracking_mpc.studies.faults.kinds.cpu_starvation import PER_CORE, CpuStarvation


def test_busy_processes_are_ended():
    fault = CpuStarvation()
    fault.begin(None, 1.0, 0)
    busy = fault._busy
    assert len(busy) == PER_CORE * os.cpu_count()
    assert all(process.poll() is None for process in busy)
    fault.end(None)
    assert all(process.poll() is not None for process in busy)
