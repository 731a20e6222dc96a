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

"""The controller as a managed node: its transitions, its peers, and what it says of them."""

from __future__ import annotations

import dataclasses
import gc
import threading
from collections import Counter

import numpy as np
import pytest
from processes import refused_start, wait_for

from uav_tracking_mpc.control.fallback import FallbackMode
from uav_tracking_mpc.control.record import replay
from uav_tracking_mpc.nodes.messages.conversions import plan_from_command
from uav_tracking_mpc.nodes.nmpc_controller import NmpcController

pytestmark = pytest.mark.nodes


def test_without_autostart_a_manager_brings_it_up_and_down(flight):
    flight.add_all(autostart=False)
    assert flight.state() == "unconfigured"
    assert flight.spin(lambda: len(flight.states) > 30)
    assert not flight.commands
    assert flight.spin(lambda: flight.says())
    assert flight.told()[1]["configured"] == "False"
    assert flight.change("configure")
    assert flight.state() == "inactive"
    flight.fly(1.0)
    assert not flight.commands
    assert flight.change("activate")
    assert flight.commanded()

    # Deactivated it is silent: the vehicle flies the plan to its end, then holds.
    assert flight.change("deactivate")
    assert flight.state() == "inactive"
    flight.fly(0.3)
    flight.commands.clear()
    plan = flight.simulator._plant.plan
    assert flight.spin(lambda: plan.holding)
    assert not flight.commands
    assert flight.told()[0] == "inactive: no command is sent"
    assert plan.failsafes == 1

    assert flight.change("activate")
    assert flight.commanded()
    assert not plan.holding


@pytest.mark.parametrize(
    ("before", "shutdown"),
    [((), "active_shutdown"), (("deactivate", "cleanup"), "unconfigured_shutdown")],
)
def test_a_node_that_was_shut_down_says_so_and_sends_nothing(flying, before, shutdown):
    assert flying.change(*before, shutdown)
    assert flying.state() == "finalized"
    flying.fly(0.3)
    flying.commands.clear()
    flying.diagnostics.clear()
    assert flying.spin(lambda: len(flying.says()) >= 2)  # it goes on saying so
    flying.fly(2.5)
    assert not flying.commands
    said = flying.says()
    assert {status.level for status in said} == {b"\x01"}
    assert all(status.message.startswith("shut down: no command") for status in said)
    assert flying.told()[1]["lifecycle state"] == "finalized"


def test_after_a_rest_the_first_command_comes_from_an_optimal_plan(flight):
    """However long the target's position would have been valid."""
    flight.add_all(target_timeout=1.0)
    assert flight.commanded()
    for _ in range(2):
        assert flight.change("deactivate")
        flight.fly(4.0)
        assert flight.told()[1]["lifecycle state"] == "inactive"
        modes = flight.controller.controller.modes
        before = dict(modes.counts)
        assert flight.change("activate")
        flight.commands.clear()
        assert flight.commanded(20)
        assert flight.told()[0] == "tracking: optimal plan"
        flown = {mode for mode in modes.counts if modes.counts[mode] > before[mode]}
        assert flown <= {FallbackMode.OPTIMAL, FallbackMode.SILENCE}
    assert flight.controller.report.refused == 0


def test_a_vehicle_that_falls_silent_is_told_at_once_and_nobody_else_is_blamed(flight):
    """Of wall time, for the clock is real, control periods pass in silence: they are counted.

    It is the vehicle's state that is missing: nobody's clock is wrong, no target is refused once
    that is told. A busy machine may tell it later than a target's stamp is too far ahead.
    """
    flight.add_all(speed=None, target_timeout=1.0)
    assert flight.commanded(40)
    assert flight.told()[1]["publishers of uav/odometry"] == "1"
    report = flight.controller.report
    before = report.deadlines_missed
    flight.remove(flight.simulator)
    words = "nobody publishes uav/odometry any more"
    assert flight.spin(lambda: flight.told()[0] == words or flight.told()[0].endswith("sent"))
    said = [status.message for status in flight.says("")]
    assert said.count(words) <= 2  # the event, and the second that it may stand
    assert flight.tells("vehicle state is lost")
    assert "uav/odometry" in flight.told()[0]
    refused = report.refused
    # Of two control periods each: longer than a target may be ahead of a state.
    assert flight.spin(lambda: report.deadlines_missed > before + 20)
    assert report.refused == refused


def own_objects():
    """How many objects of each class of the package there are."""
    gc.collect()
    kinds = (type(thing) for thing in gc.get_objects())
    return Counter(kind for kind in kinds if str(kind.__module__).startswith("uav_tracking_mpc."))


def no_margins():
    return "margins" not in {thread.name for thread in threading.enumerate()}


def test_a_cycle_through_all_states_leaves_nothing_behind(flight, monkeypatch):
    """No judgement of margins waits for a controller that is gone; no object of it stays."""
    monkeypatch.setattr("uav_tracking_mpc.nodes.nmpc_controller.MARGIN_PATIENCE", 1e6)
    flight.add_all(autostart=False)
    before = Counter()
    for cycle in range(4):
        assert flight.change("configure", "activate")
        assert flight.commanded(3)
        assert flight.change("deactivate", "cleanup")
        if cycle == 1:  # all that is loaded once is loaded
            assert wait_for(no_margins)
            before = own_objects()
    assert wait_for(no_margins)  # are judged any more
    assert not own_objects() - before


def test_a_transition_that_is_not_possible_is_refused_and_the_node_flies_on(flying):
    for transition in ("activate", "cleanup", "configure", "unconfigured_shutdown"):
        assert not flying.change(transition)
    assert flying.state() == "active"
    assert flying.commanded()


def test_a_transition_that_fails_leads_back_to_unconfigured_with_the_reason(flight, monkeypatch):
    flight.add_all(autostart=False)
    assert flight.change("configure")

    def broken(self):
        raise ArithmeticError("no such number")

    with monkeypatch.context() as patched:
        patched.setattr(NmpcController, "activate", broken)
        assert not flight.change("activate")
    assert flight.state() == "unconfigured"
    words = "cannot be activated: ArithmeticError: no such number"
    assert flight.spin(lambda: flight.told()[0] == words)
    assert flight.told()[1]["lifecycle state"] == "unconfigured"
    assert flight.change("configure", "activate")
    assert flight.commanded()


def test_in_a_namespace_the_services_and_the_aircraft_have_its_name(flight):
    flight.add(NmpcController, namespace="red", autostart=False)
    assert flight.state("red/nmpc_controller") == "unconfigured"
    assert flight.spin(
        lambda: any(s.hardware_id == "red" for m in flight.diagnostics for s in m.status)
    )


def test_an_orbit_that_cannot_be_flown_is_not_configured(flight):
    """Set while unconfigured: each value is allowed, together they are not."""
    flight.add_all(autostart=False)
    assert "needs a turn rate" in flight.set(range=130.0, altitude=120.0)
    flight.controller.parameters = dataclasses.replace(
        flight.controller.parameters, certificate="/nowhere.json", terminal_constraint="none",
        rate_lag=(0.0,) * 3, dead_time=(0.0,) * 3, response_estimation=False,
    )  # fmt: skip
    assert not flight.change("configure")
    assert flight.state() == "unconfigured"
    assert flight.spin(lambda: flight.told()[0].startswith("cannot be configured"))
    words, values = flight.told()
    assert values["configured"] == "False"
    assert "'certificate' is '/nowhere.json'" in values["reason"]
    assert "'certificate' is '/nowhere.json'" in words


def test_with_autostart_that_ends_the_process():
    arguments = ("-p", "certificate:=/nowhere.json", "-p", "terminal_constraint:=hard")
    assert "'certificate' is '/nowhere.json'" in refused_start("nmpc_controller", *arguments)


def test_what_is_compiled_changes_after_cleanup_alone_and_the_rest_while_inactive(flying):
    refusal = flying.set(limit_penalty=500.0)
    assert "must stay 2000.0 while the controller is configured" in refusal
    assert flying.change("deactivate")
    assert flying.set(range=340.0) == ""
    assert flying.set(horizon=30)
    flying.fly(1.5)
    assert flying.told()[0] == "inactive: no command is sent"
    assert flying.change("cleanup")
    assert flying.state() == "unconfigured"
    assert flying.set(horizon=20) == ""
    assert flying.controller.parameters.horizon == 20
    assert flying.change("configure", "activate")
    flying.commands.clear()
    assert flying.commanded()
    assert len(flying.commands[-1].points) == 20
    assert flying.controller.controller.orbit.range == 340.0


def test_what_the_node_flew_is_flown_again_bit_for_bit(flight, tmp_path):
    """In wind, with another orbit in between; until a solve met its time budget."""
    path = tmp_path / "controller.jsonl"
    flight.add_all(record=str(path), solve_time_max=5.0)
    assert flight.commanded(20)
    assert flight.set(range=340.0) == ""
    assert flight.commanded(20)
    assert flight.change("deactivate", "cleanup")
    steps = list(replay(path))
    recorded = [step.recorded for step in steps if step.recorded is not None]
    assert not any(command.out_of_time for command in recorded)
    assert all(step.same for step in steps)
    sent = [plan_from_command(message)[0] for message in flight.commands]
    np.testing.assert_array_equal(sent, [command.inputs for command in recorded][-len(sent) :])


def test_a_law_flies_in_the_place_of_the_predictive_controller(flight):
    flight.add_all(law="l1")
    assert flight.commanded(20)
    _, values = flight.told()
    assert (values["mode"], values["solver"]) == ("guidance law", "none")
