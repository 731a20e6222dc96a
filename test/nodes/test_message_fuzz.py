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

"""Messages right and wrong into the callbacks of controller and vehicle, found by Hypothesis.

No middleware in between: what a run finds, it finds again. In the suite a few flights; ``pytest -m
long`` flies a hundred long ones.
"""

import gc

import numpy as np
import pytest
from controller_flight import CONFIGURATION, ControllerFlight
from hypothesis import HealthCheck, settings
from hypothesis.stateful import run_state_machine_as_test
from node_harness import NodeHarness, silent_ros
from vehicle_flight import VehicleFlight

from uav_tracking_mpc.nodes.messages.wires import CommandWire
from uav_tracking_mpc.nodes.nmpc_controller import NmpcController
from uav_tracking_mpc.nodes.topics import COMMAND
from uav_tracking_mpc.nodes.uav_simulator import UavSimulator

pytestmark = pytest.mark.nodes

SHORT = settings(
    max_examples=2,
    stateful_step_count=20,
    deadline=None,
    derandomize=True,
    database=None,
    suppress_health_check=list(HealthCheck),
)
LONG = settings(SHORT, max_examples=100, stateful_step_count=60, derandomize=False)


@pytest.fixture(scope="module")
def controller():
    with silent_ros():
        ControllerFlight.harness = NodeHarness(
            NmpcController,
            CONFIGURATION.controller,
            refusals=lambda node: node.report.refused,
            # The solver's workspace is overwritten by every solve; a doubtful state is remembered,
            # to judge the next ones; the first stamp, whatever it is, is where times are counted
            # from. Margins are judged in a thread, which ends when it will.
            may_change=("formulation", "_outliers", "reason", "events", "_margins"),
            use_sim_time=True,
            delay_margin_min=0.0,  # judged beside the flight, at times of its own
            gain_margin_min=0.0,
        )
        yield ControllerFlight
        ControllerFlight.harness.node.destroy_node()
        ControllerFlight.harness = VehicleFlight.harness = None
        gc.collect()  # a participant that stays would meet those of the tests that follow


def fly(flight, how):
    """Flights as Hypothesis makes them up; an error that comes once only is told as well."""
    try:
        run_state_machine_as_test(flight, settings=how)
    except BaseException as error:
        raise AssertionError(flight.harness.first_error) from error


def test_no_message_breaks_the_controller(controller):
    fly(controller, SHORT)
    assert controller.commands > 100
    assert len(controller.refused) >= 2


def test_no_message_breaks_the_vehicle(controller):
    fly(VehicleFlight, settings(SHORT, max_examples=6))  # a flight takes it a tenth of the time
    assert VehicleFlight.refused > 20
    assert VehicleFlight.accepted > 20


@pytest.mark.long
@pytest.mark.parametrize("flight", [ControllerFlight, VehicleFlight])
def test_no_message_breaks_anything_in_thousands_of_steps(controller, flight):
    fly(flight, LONG)


def flown(controller):
    """A flight without a wrong message."""
    flight = controller()
    flight.take_off(start=0, distance=1.0, azimuth=0.0, altitude=1.0, heading=0.0)
    flight.rounds(20)
    return flight


def test_an_exception_in_a_callback_is_found(controller, monkeypatch):
    def careless(message, frames):
        return np.linalg.inv(np.zeros((3, 3))).diagonal()

    monkeypatch.setattr("uav_tracking_mpc.nodes.messages.conversions.position_from_point", careless)
    with pytest.raises(np.linalg.LinAlgError):
        flown(controller)


def test_a_command_outside_the_limits_is_found(controller, monkeypatch):
    write = CommandWire.write

    def beyond(wire, stamp, plan, *rest):
        return write(wire, stamp, plan + 9.0, *rest)

    monkeypatch.setattr(CommandWire, "write", beyond)
    with pytest.raises(AssertionError, match="command limits"):
        flown(controller)


def test_a_refused_command_that_is_flown_all_the_same_is_found(controller, monkeypatch):
    on_command = UavSimulator._on_command

    def careless(self, message):
        self._plant.time += 1.0
        on_command(self, message)

    monkeypatch.setattr(UavSimulator, "_on_command", careless)
    flight = VehicleFlight()
    with pytest.raises(AssertionError, match="a refused message changed _plant.time"):
        flight.harness.deliver(COMMAND.name, COMMAND.type())
    flight.teardown()


def test_a_process_that_is_stopped_while_it_answers_sends_nothing(controller, monkeypatch):
    flight = flown(controller)
    node, commanded = flight.harness.node, flight.commanded
    step, refused = node.controller.step, node.report.refused

    def slow(measurement, now):
        command = step(measurement, now)
        flight.harness.clock += 2.0
        return command

    monkeypatch.setattr(node.controller, "step", slow)
    topic, message = flight.next_round()[2]
    assert commanded > 0
    flight.harness.tell(topic.name, message)
    assert flight.commanded == commanded
    assert node.report.refused == refused + 1
