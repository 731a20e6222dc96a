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

"""The short form of ``make golden``: flights of today are those that were recorded."""

import subprocess
import sys
from pathlib import Path

GOLDEN = Path(__file__).with_name("golden.py")
RECORDS = (
    "paper: mission: nmpc",
    "small_uav: scenario gusts: nmpc",
    "small_uav: mission: l1",
    "bag",
)


def test_recorded_flights_are_flown_again():
    """Within the tolerances of other processors; a change that is meant is recorded anew."""
    finished = subprocess.run([sys.executable, GOLDEN, *RECORDS], capture_output=True, text=True)
    assert finished.returncode == 0, finished.stdout + finished.stderr
    assert f"{len(RECORDS)} records: " in finished.stdout
