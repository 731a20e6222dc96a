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

from uav_tracking_mpc.nodes.stall_guard import DRAIN, StallGuard


def test_what_is_heard_first_after_a_stall_is_old():
    guard = StallGuard(0.4)
    assert guard.alive(10.0)
    assert guard.alive(10.39)
    assert not guard.alive(12.0)  # stopped for 1.6 s
    assert not guard.alive(12.0 + 0.9 * DRAIN)
    assert guard.alive(12.0 + 1.1 * DRAIN)
    assert guard.stalls == 1


def test_a_first_message_is_no_stall():
    assert StallGuard(0.4).alive(1e6)
