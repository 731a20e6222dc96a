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

"""Nodes for a test: alone, a flight of all three, and one that is under way."""

import signal

import pytest


@pytest.fixture
def nodes(request):
    """Of an executor that a test may name."""
    from node_harness import Nodes

    nodes = Nodes(*filter(None, [getattr(request, "param", None)]))
    yield nodes
    nodes.end()


@pytest.fixture
def flight():
    from node_flight import Flight

    flight = Flight()
    yield flight
    flight.end()


@pytest.fixture
def flying(flight):
    """The flight with its three nodes, as commands come."""
    flight.add_all()
    assert flight.commanded()
    return flight


@pytest.fixture
def run_here(capfd):
    """Runs a node in this process as in one of its own; its exit code and what it said."""
    from uav_tracking_mpc.nodes.ros.process import run

    # A node that was stopped leaves signals ignored, and children would inherit that.
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}

    def run_here(name, create, *arguments):
        code, said = run(name, create, arguments), capfd.readouterr()
        return code, said.out + said.err

    yield run_here
    for number, handler in before.items():
        signal.signal(number, handler)
