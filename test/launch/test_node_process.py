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

"""The page of a flight as a process: nobody waits for it, and it goes with the flight."""

import os
import signal
import textwrap
import threading

import pytest
from processes import alive, wait_for
from rich.console import Console

from uav_tracking_mpc.launch import node_process as module
from uav_tracking_mpc.launch.node_process import page_process


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
    monkeypatch.setattr(module, "MODULE", "stand_in_page")
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
    with page_process(42, ("--port", "8081"), console) as page:
        _, identity, *_ = first_line(lines)
        interrupt = threading.Thread(
            target=lambda: (
                wait_for(lambda: any("until Ctrl-C" in line for line in lines()), 20.0),
                os.kill(os.getpid(), signal.SIGINT),
            )
        )
        interrupt.start()
        page.stay()
        interrupt.join()
        assert alive(int(identity))  # until the context ends
    assert not alive(int(identity))


def test_nobody_stays_for_a_page_that_has_ended(served):
    console, lines = served
    with page_process(42, ("--die", "--port", "8081"), console) as page:
        _, identity, *_ = first_line(lines)
        page.stay()
    assert not alive(int(identity))
