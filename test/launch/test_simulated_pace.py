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

import dataclasses
import io
from types import SimpleNamespace

import pytest
from rich.console import Console

pytest.importorskip("rclpy")

from uav_tracking_mpc.launch import simulated_pace
from uav_tracking_mpc.launch.simulated_pace import SimulatedPace
from uav_tracking_mpc.mpc import machine_code
from uav_tracking_mpc.settings.configuration import load_configuration


class Client:
    """Of the simulator's parameters; answers at once."""

    def __init__(self, refusal=""):
        self.asked, self.refusal = [], refusal

    def service_is_ready(self):
        return True

    def call_async(self, request):
        self.asked += [(p.name, p.value.double_value) for p in request.parameters]
        result = SimpleNamespace(successful=not self.refusal, reason=self.refusal)
        future = SimpleNamespace(result=lambda: SimpleNamespace(results=[result]))
        future.add_done_callback = lambda callback: callback(future)
        return future


@pytest.fixture
def paced(monkeypatch, tmp_path):
    """Makes a pace for a mission of that speed; and folder, client and what is said."""
    monkeypatch.setattr(simulated_pace, "compiled_into", lambda parameters: tmp_path)

    def make(speed, client):
        configuration = load_configuration("paper", [f"mission.speed={speed}"])
        node = SimpleNamespace(create_client=lambda *_: client)
        said = io.StringIO()
        return SimulatedPace(configuration, node, Console(file=said)), said

    return make


def test_it_is_real_time_until_the_solver_is_compiled(paced, tmp_path):
    client = Client()
    pace, said = paced(8.0, client)
    assert pace.speed == 1.0
    pace.follow()
    assert client.asked == []
    (tmp_path / machine_code.DESCRIPTION).write_text("{}")
    pace.follow()
    pace.follow()
    assert client.asked == [("speed", 8.0)]
    assert said.getvalue() == ""


def test_what_is_compiled_flies_as_fast_as_asked(paced, tmp_path):
    (tmp_path / machine_code.DESCRIPTION).write_text("{}")
    client = Client()
    pace, _ = paced(8.0, client)
    assert pace.speed == 8.0
    pace.follow()
    assert client.asked == []


def test_slower_than_real_time_stays(paced):
    assert paced(0.5, Client())[0].speed == 0.5


def test_a_refusal_is_said(paced, tmp_path):
    pace, said = paced(8.0, Client("read-only"))
    (tmp_path / machine_code.DESCRIPTION).write_text("{}")
    pace.follow()
    assert said.getvalue() == "simulated time goes on at 1 times real time: read-only\n"


def test_a_law_needs_nothing_compiled():
    parameters = load_configuration("paper").controller
    assert simulated_pace.compiled_into(dataclasses.replace(parameters, law="l1")) is None
