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

"""/diagnostics of a node: whose, by which time, and what of it reaches the log."""

from types import SimpleNamespace

import pytest
import rclpy
from rclpy.parameter import Parameter

from uav_tracking_mpc.nodes import diagnostics
from uav_tracking_mpc.nodes.diagnostics import ERROR, OK, WARN, Diagnostics
from uav_tracking_mpc.nodes.uav_simulator import UavSimulator

pytestmark = pytest.mark.nodes


@pytest.fixture
def told(context, monkeypatch):
    """Diagnostics of a node by a clock that stands, and what it logs and publishes."""
    node = rclpy.create_node("pilot", context=context, namespace="red/wing")
    log, now = [], [100.0]
    logger = SimpleNamespace(
        info=lambda words: log.append(("info", words)),
        warning=lambda words: log.append(("warning", words)),
        error=lambda words: log.append(("error", words)),
    )
    monkeypatch.setattr(node, "get_logger", lambda: logger)
    monkeypatch.setattr(diagnostics.time, "monotonic", lambda: now[0])
    made = Diagnostics(node, lambda: {"height [m]": 120.0})
    sent = []
    made._publisher.publish = sent.append
    yield SimpleNamespace(by=made, log=log, now=now, sent=sent)
    node.destroy_node()


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
    assert told.by.level == WARN


def test_later_it_is_one_at_once_and_its_reason_stands_in_the_log_alone(told):
    told.by.report(OK, "flying")
    told.by.report(ERROR, "flying a law", "the target is lost")
    told.by.report(ERROR, "flying a law", "the target is lost still")
    assert told.log == [("info", "flying"), ("error", "flying a law: the target is lost")]
    assert told.by.message == "flying a law"


def test_a_status_that_alternates_is_logged_once(told):
    told.by.report(OK, "flying")
    for tick in range(400):
        told.now[0] += 0.05
        told.by.report(*((WARN, "too slow") if tick % 2 else (OK, "flying")))
    assert told.log == [("info", "flying"), ("warning", "too slow")]


@pytest.mark.parametrize("driven", [True, False])
def test_the_simulator_stamps_by_the_time_that_it_makes(context, driven):
    node = UavSimulator(
        context=context, parameter_overrides=[Parameter("publish_clock", value=driven)]
    )
    sent = []
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
    node.destroy_node()
