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

from __future__ import annotations

import sys

import pytest

from uav_tracking_mpc.studies.benchmark import start_timing


def test_a_controller_that_is_started_flies_an_optimal_plan(capsys):
    start_timing.fly_first_plan("paper")
    assert capsys.readouterr().out.splitlines()[-1] == start_timing.FIRST_PLAN


def test_the_time_ends_with_the_first_plan(tmp_path):
    words = f"import time; print({start_timing.FIRST_PLAN!r}, flush=True); time.sleep(60.0)"
    taken = start_timing._until_first_plan([sys.executable, "-c", words], str(tmp_path))
    assert 0.0 < taken < 50.0


def test_a_process_without_a_plan_is_no_time(tmp_path):
    with pytest.raises(RuntimeError, match="ended without a plan"):
        start_timing._until_first_plan([sys.executable, "-c", "print('no')"], str(tmp_path))


def test_in_words():
    found = {
        "config": "paper", "compile_s": 5.0,
        "controller_first_cpu_s": 1.2, "controller_later_cpu_s": 0.7,
        "controller_first_s": 1.5, "controller_later_s": 0.75,
        "flight_first_s": None, "flight_later_s": None,
    }  # fmt: skip
    words = "\n".join(start_timing.in_words(found))
    assert "controller alone: 1.50 s with an empty cache, 0.75 s later" in words
    assert "nodes" not in words
