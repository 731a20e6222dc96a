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

"""Waits for events, with one limit: what has not come in a minute does not come."""

from __future__ import annotations

import time

PATIENCE = 60.0  # s; for what is broken, not a measure of what works


def wait_for(condition, limit=PATIENCE):
    """Whether a condition comes to hold."""
    return _until(condition, limit, lambda: time.sleep(0.02))


def spin(executor, until, limit=PATIENCE):
    """Whether a condition comes to hold while an executor of rclpy spins."""
    return _until(until, limit, lambda: executor.spin_once(timeout_sec=0.02))


def _until(condition, limit, meanwhile):
    deadline = time.monotonic() + limit
    while True:
        meanwhile()
        if condition():
            return True
        if time.monotonic() >= deadline:
            return False
