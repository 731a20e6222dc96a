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

"""What a flight says in the terminal."""

import io

import pytest
from rich.console import Console
from waiting import wait_for

pytest.importorskip("rclpy")

from uav_tracking_mpc.launch.flight import progress_line
from uav_tracking_mpc.launch.node_process import NodeProcess
from uav_tracking_mpc.nodes.flight_recorder import Progress


def test_the_progress_fits_a_terminal():
    line = progress_line(Progress(3600.0, True, 1234.5, 432.1, 31.9, 0.0123))
    assert line.startswith("t 3600 s  range 1234.5 m")
    assert "12300 us" in line
    assert len(f"{line} 100%") <= 80


def test_the_log_of_a_node_names_it_once(tmp_path, monkeypatch):
    (tmp_path / "talker.py").write_text(
        "print('[INFO] [12.5] [pilot]: flying, says [pilot]: so'); print('by print')"
    )
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    told = io.StringIO()
    process = NodeProcess("pilot", "talker", [], Console(file=told, width=80))
    assert wait_for(lambda: process.exit_code is not None)
    process.stop(15)
    assert told.getvalue().splitlines() == [
        "[pilot] [INFO] [12.5]: flying, says [pilot]: so",
        "[pilot] by print",
    ]
