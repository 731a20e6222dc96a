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

"""/diagnostics of a node: whose, by which time, what is shown, and what reaches the log."""

import functools
from types import SimpleNamespace

import pytest
from rclpy.node import Node

from uav_tracking_mpc.nodes.ros import diagnostics
from uav_tracking_mpc.nodes.ros.diagnostics import (
    ERROR,
    LASTING,
    OK,
    WARN,
    Diagnostics,
    SteadyStatus,
)
from uav_tracking_mpc.nodes.topics import DIAGNOSTICS
from uav_tracking_mpc.nodes.uav_simulator import UavSimulator

pytestmark = pytest.mark.nodes
TICK = 0.05


def shown(*script):
    """Each change that is shown of (levels in turn, seconds), every 50 ms after a fine time."""
    status, now, seen = SteadyStatus(WARN, "starting"), 0.0, []
    for levels, seconds in ((OK, 10.0), *script):
        for tick in range(round(seconds / TICK)):
            level = levels[tick % len(levels) :][:1]
            if status.see(level, f"level {level[0]}", now):
                seen.append(level)
            now += TICK
    return seen


def test_at_the_start_every_change_is_shown():
    status = SteadyStatus(WARN, "starting")
    for tick, words in enumerate(("waiting for one", "waiting for another")):
        assert status.see(WARN, words, 0.01 * tick)
        assert status.message == words
    assert status.see(OK, "flying", 0.03)


def test_an_error_at_the_start_is_shown_once_however_often_it_comes_and_goes():
    """As on a machine that plans too slowly until the solver is compiled."""
    status = SteadyStatus(WARN, "starting")
    told = [status.see((WARN, ERROR)[tick % 2], "slow", TICK * tick) for tick in range(600)]
    assert sum(told) <= 2
    assert status.level == ERROR


@pytest.mark.parametrize("worse", [WARN, ERROR])
def test_what_alternates_twenty_times_a_second_is_shown_as_its_worse_half(worse):
    assert shown((worse + OK, 30.0)) == [OK, worse]


def test_a_better_status_is_shown_when_it_has_lasted():
    assert shown((WARN + OK, 1.0), (OK, LASTING - 0.2)) == [OK, WARN]
    assert shown((WARN + OK, 1.0), (OK, LASTING + 0.2)) == [OK, WARN, OK]


def test_a_worse_status_is_shown_at_once_and_one_that_stood_ends_at_once():
    assert shown((ERROR, TICK)) == [OK, ERROR]
    assert shown((ERROR, LASTING + 0.2), (OK, TICK)) == [OK, ERROR, OK]


def test_two_that_are_better_may_alternate():
    """The bad one is over all the same."""
    assert shown((ERROR, 0.1), (OK + WARN, 3 * LASTING)) in (
        [OK, ERROR, WARN],
        [OK, ERROR, OK, WARN],
    )


def test_what_somebody_asked_for_is_shown_at_once():
    status = SteadyStatus(WARN, "starting")
    status.see(OK, "flying", 0.0)
    status.see(ERROR, "lost", 0.1)
    status.begin(WARN, "inactive")
    assert (status.level, status.message) == (WARN, "inactive")
    assert status.see(OK, "flying", 0.2)


@pytest.fixture
def told(nodes, monkeypatch):
    """Diagnostics of a node by a clock that stands, and what it logs and publishes."""
    node = nodes.add(functools.partial(Node, "pilot"), namespace="red/wing")
    log, now = [], [100.0]
    logger = SimpleNamespace(
        info=lambda words: log.append(("info", words)),
        warning=lambda words: log.append(("warning", words)),
        error=lambda words: log.append(("error", words)),
    )
    monkeypatch.setattr(node, "get_logger", lambda: logger)
    monkeypatch.setattr(diagnostics.time, "monotonic", lambda: now[0])
    made, sent = Diagnostics(node, lambda: {"height [m]": 120.0}), []
    made._publisher.publish = sent.append
    return SimpleNamespace(by=made, log=log, now=now, sent=sent)


def test_the_aircraft_is_the_namespace(told):
    told.by.report(OK, "flying")
    (status,) = told.sent[-1].status
    assert (status.name, status.hardware_id) == ("red/wing/pilot: status", "red/wing")
    assert [(value.key, value.value) for value in status.values] == [("height [m]", "120")]


def test_what_is_not_there_yet_at_the_start_is_a_warning_only_after_a_while(told):
    told.by.report(WARN, "waiting for a state")
    assert told.log == [("info", "waiting for a state")]
    told.now[0] += 0.5 * diagnostics.STARTING
    told.by._repeat()
    assert len(told.log) == 1
    told.now[0] += diagnostics.STARTING
    told.by._repeat()
    told.by._repeat()
    assert told.log[1:] == [("warning", "waiting for a state")]
    assert told.by.status.level == WARN


def test_later_it_is_one_at_once_and_its_reason_stands_in_the_log_alone(told):
    told.by.report(OK, "flying")
    told.by.report(ERROR, "flying a law", "the target is lost")
    told.by.report(ERROR, "flying a law", "the target is lost still")
    assert told.log == [("info", "flying"), ("error", "flying a law: the target is lost")]
    assert told.by.status.message == "flying a law"


def test_a_status_that_alternates_is_logged_once(told):
    told.by.report(OK, "flying")
    for tick in range(400):
        told.now[0] += 0.05
        told.by.report(*((WARN, "too slow") if tick % 2 else (OK, "flying")))
    assert told.log == [("info", "flying"), ("warning", "too slow")]


@pytest.mark.parametrize("driven", [True, False])
def test_the_simulator_stamps_by_the_time_that_it_makes(nodes, driven):
    node, sent = nodes.add(UavSimulator, publish_clock=driven), []
    node._diagnostics._publisher.publish = sent.append
    for _ in range(3):
        node._step()
    node._diagnostics.publish()
    stamp = sent[-1].header.stamp
    seconds = stamp.sec + 1e-9 * stamp.nanosec
    if driven:
        assert seconds == pytest.approx(3 / node.parameters.state_rate)
    else:
        assert seconds > 1e9


def test_who_begins_to_listen_hears_at_once_how_the_node_is(nodes, monkeypatch):
    monkeypatch.setattr(diagnostics, "steady_timer", lambda *_: None)  # nothing is repeated
    Diagnostics(nodes.peer("node"), dict).announce(OK, "fine")
    for listener in ("first", "second"):
        heard = nodes.listen(DIAGNOSTICS, by=nodes.peer(listener))[DIAGNOSTICS.name]
        assert nodes.spin(lambda heard=heard: heard)
        assert heard[-1].status[0].message == "fine"
