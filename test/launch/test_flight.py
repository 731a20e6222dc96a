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

"""A flight of real nodes: its progress, its pace, the death of its controller, its page."""

from __future__ import annotations

import io
import os
import signal
import textwrap
import threading
from types import SimpleNamespace

import pytest
from processes import alive, wait_for
from rich.console import Console
from std_srvs.srv import Trigger

from uav_tracking_mpc.launch import flight
from uav_tracking_mpc.launch.flight import SimulatedPace, page_process, progress_line, serve_kill
from uav_tracking_mpc.launch.supervisor import NodeProcess, Supervisor
from uav_tracking_mpc.mpc import machine_code
from uav_tracking_mpc.nodes.flight_recorder import Progress
from uav_tracking_mpc.settings.configuration import load_configuration

pytest.importorskip("rclpy")


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


class Client:
    """Of the simulator's parameters; answers at once."""

    def __init__(self, refusal=""):
        self.asked, self.refusal = [], refusal

    def service_is_ready(self):
        return True

    def call_async(self, request):
        self.asked += [(p.name, p.value.double_value) for p in request.parameters]
        result = SimpleNamespace(successful=not self.refusal, reason=self.refusal)
        future = SimpleNamespace(result=lambda: SimpleNamespace(result=result))
        future.add_done_callback = lambda callback: callback(future)
        return future


@pytest.fixture
def paced(monkeypatch, tmp_path):
    """Makes a pace for a mission of that speed; and folder, client and what is said."""
    monkeypatch.setattr(flight, "compiled_into", lambda parameters: tmp_path)

    def make(speed, client):
        configuration = load_configuration("paper", [f"mission.speed={speed}"])
        node = SimpleNamespace(create_client=lambda *_, **__: client)
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


SERVER = ("http.server", ["0", "--bind", "127.0.0.1"])  # runs until it is ended


@pytest.fixture
def supervisor(tmp_path):
    with (tmp_path / "output").open("w") as file:
        supervisor = Supervisor(tmp_path, Console(file=file), domain=7)
        for name in ("nmpc_controller", "uav_simulator"):
            supervisor.start(name, *SERVER)
        yield supervisor
        supervisor.end()


def test_the_controller_alone_is_killed_and_runs_again(supervisor):
    services = {}
    node = SimpleNamespace(create_service=lambda kind, name, call: services.update({name: call}))
    kill = serve_kill(node, supervisor)
    before = {name: process.identity for name, process in supervisor.processes.items()}
    kill()
    assert supervisor.processes["nmpc_controller"].identity == before["nmpc_controller"]
    answer = services["nmpc_controller/kill"](Trigger.Request(), Trigger.Response())
    assert (answer.success, answer.message) == (True, "nmpc_controller is killed and started again")
    assert alive(before["nmpc_controller"])  # the callback itself waits for no process
    kill()
    assert not alive(before["nmpc_controller"])
    again = supervisor.processes["nmpc_controller"].identity
    assert again != before["nmpc_controller"] and alive(again)
    assert supervisor.processes["uav_simulator"].identity == before["uav_simulator"]
    supervisor.check()  # nobody misses the one that was killed
    kill()
    assert supervisor.processes["nmpc_controller"].identity == again


@pytest.fixture
def served(tmp_path, monkeypatch):
    """A stand-in for the command; returns its lines of output."""
    (tmp_path / "stand_in_page.py").write_text(
        textwrap.dedent(
            """
            import os, sys, time
            print(os.getpid(), *sys.argv[1:])
            if "--die" in sys.argv:
                sys.exit(2)
            time.sleep(600.0)
            """
        )
    )
    monkeypatch.setattr(flight, "COMMAND", "stand_in_page")
    monkeypatch.setenv("PYTHONPATH", f"{tmp_path}:{os.environ.get('PYTHONPATH', '')}")
    output = tmp_path / "output"
    with output.open("w") as file:
        yield Console(file=file, width=200), lambda: output.read_text().splitlines()


def first_line(lines):
    assert wait_for(lambda: lines() and lines()[0].endswith("8081"))
    return lines()[0].split()


def test_it_shows_the_domain_and_ends_with_the_context(served):
    console, lines = served
    with page_process(42, ("--port", "8081"), console):
        mark, identity, *words = first_line(lines)
        assert mark == "[page]"
        assert words == ["view", "--domain-id", "42", "--port", "8081"]
        assert alive(int(identity))
    assert not alive(int(identity))


def test_it_stays_until_ctrl_c(served):
    console, lines = served
    with page_process(42, ("--port", "8081"), console) as stay:
        _, identity, *_ = first_line(lines)
        interrupt = threading.Thread(
            target=lambda: (
                wait_for(lambda: any("until Ctrl-C" in line for line in lines()), 20.0),
                os.kill(os.getpid(), signal.SIGINT),
            )
        )
        interrupt.start()
        stay()
        interrupt.join()
        assert alive(int(identity))  # until the context ends
    assert not alive(int(identity))


def test_nobody_stays_for_a_page_that_has_ended(served):
    console, lines = served
    with page_process(42, ("--die", "--port", "8081"), console) as stay:
        _, identity, *_ = first_line(lines)
        stay()
    assert not alive(int(identity))
