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

"""Real nodes that fly cases of faults, or hours without: messages, processes, log are watched."""

from __future__ import annotations

import dataclasses
import math
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from rclpy.experimental.events_executor import EventsExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.parameter_client import AsyncParameterClient
from rclpy.serialization import serialize_message
from rich.console import Console

from uav_tracking_mpc.control.guidance import compile_flight
from uav_tracking_mpc.launch.flight import signals
from uav_tracking_mpc.launch.supervisor import NODES, LaunchError, supervised
from uav_tracking_mpc.parameters.specification import Specification, Value, specifications
from uav_tracking_mpc.report.atomic_write import json_text
from uav_tracking_mpc.settings.configuration import Configuration
from uav_tracking_mpc.studies.faults import fault_relay
from uav_tracking_mpc.studies.faults.fault_campaign import (
    STALL_LIMIT,
    CaseFindings,
    FaultCampaign,
    Injection,
)
from uav_tracking_mpc.studies.faults.invariants import Limits, Violation
from uav_tracking_mpc.studies.faults.kinds import Fault
from uav_tracking_mpc.studies.faults.observer import Observer
from uav_tracking_mpc.studies.faults.resources import Growth, Usage, usage
from uav_tracking_mpc.studies.faults.schedule import Case
from uav_tracking_mpc.studies.faults.stream_fault import ORDERS, STREAMS, raw
from uav_tracking_mpc.studies.study import Study

ANSWER_LIMIT = 5.0  # s of wall time for the parameters to be put back
SPEED = 5.0  # -, simulated over wall time, at most: five processes share the cores
START_LIMIT = 120.0  # s of wall time to fly onto the orbit the first time
TRANSPORT = 0.5  # s of wall time that messages may take, whatever the load
FENCE = 3.0  # -, times the distance at the start
RELAY = "fault_relay"
CHECK_PERIOD = 0.02  # s of wall time between looks at the processes
RESOURCES_PERIOD = 1.0  # s of wall time between looks at what they use
LOG = "nodes.log"


class ParameterClient:
    """Asks for parameters and puts them back.

    Args:
        node: Through which it asks.
        parameters: The dataclass whose fields are the controller's parameters, as configured.

    Attributes:
        known: Parameters of the controller.
        configured: Their values as configured, by name.
        asked: Requests sent.
        answered: Answers received.
        accepted: Parameters that were set.
    """

    def __init__(self, node: Node, parameters: Any) -> None:
        self._client = AsyncParameterClient(node, "nmpc_controller")
        self.known: list[Specification] = list(specifications(type(parameters)))
        self.configured: dict[str, Value] = {
            field.name: getattr(parameters, field.name) for field in dataclasses.fields(parameters)
        }
        self.asked = self.answered = self.accepted = 0
        self._put_back = 0.0

    def ask(self, values: dict[str, Any]) -> None:
        """Ask for values one by one, in one request; without a server nothing is asked.

        Args:
            values: By name, of any type.
        """
        self._send(self._client.set_parameters, values)

    def put_back(self) -> None:
        """Ask for everything as it was configured, as a whole: a part of it may not be flyable."""
        self._put_back = time.monotonic()
        values = {**self.configured, "use_sim_time": True}
        self._send(self._client.set_parameters_atomically, values)

    def _send(self, request: Callable[..., Any], values: dict[str, Any]) -> None:
        if self._client.services_are_ready():
            self.asked += 1
            asked = {k: list(v) if isinstance(v, tuple) else v for k, v in values.items()}
            wanted = [Parameter(name, value=value) for name, value in asked.items()]
            request(wanted, self._on_answer)

    def _on_answer(self, future: Any) -> None:
        if (answer := future.result()) is not None:
            self.answered += 1
            # A result each, or one for all that was configured.
            each = getattr(answer, "results", None) or [answer.result] * len(self.configured)
            self.accepted += sum(result.successful for result in each)

    @property
    def settled(self) -> bool:
        """Whether every request was answered, or too long ago.

        Answers come in order: with the last one nothing that was asked before is left.
        """
        waited = time.monotonic() - self._put_back
        return self.answered >= self.asked or waited > ANSWER_LIMIT


def limits(configuration: Configuration) -> Limits:
    """What the messages of a configuration are held to."""
    controller = configuration.controller
    target = np.array(configuration.target.position)
    distance = float(np.linalg.norm(configuration.simulator.initial_state[:3] - target))
    return Limits(
        lower=controller.input_lower,
        upper=controller.input_upper,
        state_age=controller.state_timeout,
        transport=TRANSPORT,
        floor=float(target[2]),
        fence=FENCE * max(distance, controller.range),
    )


class NodeCampaign(FaultCampaign):
    """A campaign with real nodes.

    Args:
        configuration: What to fly.
        faults: That the cases name, by label; without any there is no relay.
        output: Existing folder for the nodes' output and the bags of failing cases.
        console: Where progress goes.

    Attributes:
        growth: What each process of the three nodes of a flight used, by name and id; also of
            those that were killed since.
        supervisor: Of the node processes.
        observer: Node that hears every message.
        parameters: Client of the controller's parameters.
        reach: How far a target is teleported [m].
    """

    tolerance = 10.0

    def __init__(
        self,
        configuration: Configuration,
        faults: Mapping[str, Fault],
        output: Path,
        console: Console,
    ) -> None:
        super().__init__(configuration, faults, console)
        self._output = output
        self.speed = min(configuration.mission.speed, SPEED if faults else math.inf)
        self.reach = configuration.controller.range
        self.growth: dict[tuple[str, int], Growth] = {}
        self._deaths = 0

    def now(self) -> float:
        """See :meth:`FaultCampaign.now`: of wall time."""
        return time.monotonic() - self._begin

    def order(self, text: str) -> None:
        """Send an order to the relay, and keep it: a case may end before it would be heard."""
        order = ORDERS.type(data=text)
        self.observer.keep(ORDERS, serialize_message(order))
        self._orders.publish(order)

    def fly(
        self, cases: Iterable[Case], *, seed: int, minutes: float, domain: int | None = None
    ) -> Study:
        """Fly cases until the time is over, there are no more, or the user interrupts.

        Args:
            cases: In this order.
            seed: Of the cases, for the record.
            minutes: Wall time [min].
            domain: ROS domain; None takes one that no other launch uses.

        Returns:
            What was found.

        Raises:
            LaunchError: The aircraft did not reach its orbit before the first fault.
            KeyboardInterrupt: Before the first case was flown; later the findings are returned.
        """
        with self.flight(domain):
            interrupted = self.fly_cases(cases, end=60.0 * minutes)
        for (name, _), process in self.growth.items():
            if self.found and process.complaint():
                self.found[-1].add(Violation("growth", f"{name}: {process.complaint()}"))
        growth = {name: process.rss_percent_per_hour() for name, process in self.latest().items()}
        return self.study(
            seed,
            minutes=minutes,
            speed=self.speed,
            interrupted=interrupted,
            deaths=self._deaths,
            rss_growth_percent=max(filter(None, growth.values()), default=0.0),
            rss_growth_percent_by_node=growth,
            parameters={
                "asked": self.parameters.asked,
                "answered": self.parameters.answered,
                "accepted": self.parameters.accepted,
            },
        )

    @contextmanager
    def flight(self, domain: int | None) -> Iterator[None]:
        """Nodes that fly, with the aircraft on its orbit; all end with it.

        Args:
            domain: ROS domain; None takes one that no other launch uses.

        Raises:
            LaunchError: The aircraft did not reach its orbit.
        """
        compile_flight(self.configuration.controller)  # no other solver is tried
        path, orbit = self._output / LOG, self.configuration.controller.orbit
        log = path.open("w", encoding="utf-8")
        with (
            signals() as self._received,
            log,
            supervised(Console(file=log), domain) as self.supervisor,
            path.open(encoding="utf-8", errors="replace") as self._log_file,
        ):
            limit, wanted = limits(self.configuration), (orbit.range, orbit.altitude)
            relayed, commander = bool(self._faults), Node("campaign")
            self.observer = Observer(limit, wanted, self.recovery, self.violations, relayed)
            self._orders = commander.create_publisher(ORDERS.type, ORDERS.name, ORDERS.qos)
            self.parameters = ParameterClient(commander, self.configuration.controller)
            self._executor = EventsExecutor()
            for node in (self.observer, commander):
                self._executor.add_node(node)
            try:
                self._start(relayed)
                self._reach_orbit()
                yield
            finally:
                self._executor.shutdown()
                for node in (self.observer, commander):
                    node.destroy_node()

    def _start(self, relayed: bool) -> None:
        """Start the processes; with a relay, what nodes send goes there first."""
        self._begin = self._checked = self._sampled = time.monotonic()
        remaps = {}
        if relayed:
            self.supervisor.start(RELAY, fault_relay.__name__)
            remaps = {
                node: [f"{each.name}:={raw(each).name}" for each in STREAMS if node in each.sender]
                for node in NODES
            }
        self.supervisor.start_flight(self.configuration, self.speed, remaps)

    def _reach_orbit(self) -> None:
        self.recovery.begin()
        for _ in self._spin():
            self.sample()
            dead = self.supervisor.dead()
            if dead or self.now() > START_LIMIT:
                raise LaunchError(
                    f"the aircraft did not reach its orbit within {START_LIMIT:g} s"
                    + "".join(f"; {name} died with exit code {dead[name]}" for name in dead)
                    + f"; see {self._output / LOG}"
                )
            if self.recovery.done() is not None:
                return

    def _spin(self) -> Iterator[float]:
        """Hear messages; yield the steady time in [s] every CHECK_PERIOD.

        A signal raises KeyboardInterrupt here alone: within a callback, rclpy may turn that
        exception into others.
        """
        while True:
            self._executor.spin_once(timeout_sec=CHECK_PERIOD)
            if self._received:
                raise KeyboardInterrupt
            now = time.monotonic()
            if now - self._sampled > RESOURCES_PERIOD:
                self._sampled = now
                self._sample_resources(now)
            if now - self._checked >= CHECK_PERIOD:
                self._checked = now
                yield now

    def _sample_resources(self, now: float) -> None:
        for name, process in self.supervisor.processes.items():
            used = usage(process.identity) if name in NODES else None
            if used is not None:
                key = name, process.identity
                self.growth.setdefault(key, Growth(process.started)).add(now, used)

    def latest(self) -> dict[str, Growth]:
        """What the process of each node used that was started last, by name."""
        return {name: growth for (name, _), growth in self.growth.items()}

    def prepare(self) -> None:
        """See :meth:`FaultCampaign.prepare`."""
        self.observer.begin_case()

    def fly_case(self, case: Case) -> CaseFindings:
        """See :meth:`FaultCampaign.fly_case`; the bag of a case that fails is kept."""
        findings = super().fly_case(case)
        for line in self._log_file:
            if "Traceback" in line:
                findings.add(Violation("traceback", line.rstrip()))
        if findings.violations:
            cases = self._output / "cases"
            cases.mkdir(exist_ok=True)
            self.observer.write_bag(cases / f"case_{case.index:04d}.mcap")
        return findings

    def watch(self, injections: Sequence[Injection] = ()) -> Iterator[bool]:
        """See :meth:`FaultCampaign.watch`: messages and processes."""
        moved, flown = time.monotonic(), self.recovery.flown
        for now in self._spin():
            self.sample()
            under_way = any(not injection.settled for injection in injections)
            if under_way or self.recovery.flown != flown:
                moved, flown = now, self.recovery.flown
            for name, code in self.supervisor.dead().items():
                self._deaths += 1
                self.blame("process lost", f"{name} ended with exit code {code}")
                self.supervisor.restart(name)
            yield now - moved > STALL_LIMIT


SOAK_SPEED = 20.0  # -, simulated over wall time, as far as the machine keeps up
SETTLING = 180.0  # s of simulated time to fly onto the orbit
REPORT_PERIOD = 20.0  # s of wall time


def soak(
    configuration: Configuration,
    hours: float,
    output: Path,
    console: Console,
    domain: int | None = None,
) -> Study:
    """Fly for hours of simulated time, at the speed of the mission.

    Args:
        configuration: What to fly.
        hours: Simulated [h].
        output: Existing folder for the nodes' output.
        console: Where progress goes.
        domain: ROS domain; None takes one that no other launch uses.

    Raises:
        LaunchError: The aircraft did not reach its orbit, or time stood still.
        KeyboardInterrupt: A signal came.
    """
    campaign = NodeCampaign(configuration, {}, output, console)
    recovery = campaign.recovery
    with campaign.flight(domain):
        observer = campaign.observer
        begin, flown = time.monotonic(), recovery.flown
        settled, told = False, 0.0
        for stalled in campaign.watch():
            wall = time.monotonic() - begin
            if not settled and recovery.flown > SETTLING:
                settled, observer.longest_gap = True, 0.0
                recovery.begin()
            if recovery.flown >= 3600.0 * hours:
                break
            if stalled:
                raise LaunchError(f"simulated time stood still for {STALL_LIMIT:g} s")
            if wall - told > REPORT_PERIOD:
                told = wall
                console.print(
                    f"{recovery.flown / 3600.0:6.3f} h simulated, "
                    f"{(recovery.flown - flown) / wall:5.1f} times real time, "
                    f"r - r_d {recovery.range_error:+7.3f} m, at most {recovery.worst[0]:.3f} m, "
                    f"{observer.commands} commands",
                    highlight=False,
                )
    worst, when = recovery.worst
    nodes = {name: _told(growth) for name, growth in campaign.latest().items()}
    broken = {violation.invariant: violation.detail for violation in reversed(campaign.violations)}
    complaints = sum(bool(node["complaint"]) for node in nodes.values())
    violations = (worst > campaign.tolerance) + len(broken) + complaints
    content = {
        "config": configuration.name,
        "simulated_hours": recovery.flown / 3600.0,
        "wall_minutes": wall / 60.0,
        "speed": (recovery.flown - flown) / wall,
        "control_rate_hz": observer.commands / recovery.flown,
        "control_rate_wanted_hz": configuration.controller.control_rate,
        "longest_gap_s": observer.longest_gap,
        "max_range_error_m": worst,
        "max_range_error_at_s": when,
        "rss_growth_percent": max(node["rss_growth_percent"] for node in nodes.values()),
        "nodes": nodes,
        "broken": broken,
        "violations": violations,
    }
    return Study("soak", content, [json_text(content)], good=not violations)


def _told(growth: Growth) -> dict[str, Any]:
    """How a process grew after its warm-up."""
    half, used = growth.second_half(), [used for _, used in growth.samples] or [Usage(0, 0, 0)]
    return {
        "rss_mb": used[-1].rss / 1e6,
        "rss_growth_percent": growth.rss_percent(),
        "rss_growth_second_half_percent": half.rss_percent(),
        "handles": [used[0].handles, used[-1].handles],
        "threads": [used[0].threads, used[-1].threads],
        "complaint": half.complaint(),
    }
