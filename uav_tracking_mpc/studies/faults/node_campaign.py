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

"""Cases flown with real nodes: their messages, their processes and their log are watched."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np
from rclpy.experimental.events_executor import EventsExecutor
from rclpy.node import Node
from rich.console import Console

from uav_tracking_mpc.control.guidance import compile_flight
from uav_tracking_mpc.launch.flight import signals
from uav_tracking_mpc.launch.supervisor import NODES, LaunchError, supervised
from uav_tracking_mpc.settings.configuration import Configuration
from uav_tracking_mpc.studies.faults import fault_relay
from uav_tracking_mpc.studies.faults.fault_campaign import STALL_LIMIT, FaultCampaign, Injection
from uav_tracking_mpc.studies.faults.fault_findings import Campaign, CaseFindings
from uav_tracking_mpc.studies.faults.injected_flight import Flight, ParameterClient
from uav_tracking_mpc.studies.faults.invariants import Limits, Violation
from uav_tracking_mpc.studies.faults.kinds import Fault
from uav_tracking_mpc.studies.faults.observer import Observer
from uav_tracking_mpc.studies.faults.resources import ResourceWatch
from uav_tracking_mpc.studies.faults.schedule import Case
from uav_tracking_mpc.studies.faults.stream_fault import ORDERS, STREAMS, raw

SPEED = 5.0  # -, simulated over wall time, at most: five processes share the cores
START_LIMIT = 120.0  # s of wall time to fly onto the orbit the first time
TRANSPORT = 0.5  # s of wall time that messages may take, whatever the load
FENCE = 3.0  # -, times the distance at the start
REACH = 1.0  # -, times the range: how far a target is teleported
CHECK_PERIOD = 0.02  # s of wall time between looks at the processes
SAMPLE_PERIOD = 1.0  # s of wall time between looks at what they use
LOG = "nodes.log"
RELAY = "fault_relay"


def limits(configuration: Configuration) -> Limits:
    """What the messages of a configuration are held to.

    Args:
        configuration: That is flown.
    """
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
        faults: That the cases name, by label.
        output: Existing folder for the nodes' output and the bags of failing cases.
        console: Where progress goes.
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
        self._speed = min(SPEED, configuration.mission.speed)
        self._resources = ResourceWatch()
        self._deaths = self._log_read = 0

    def now(self) -> float:
        """See :meth:`FaultCampaign.now`: of wall time."""
        return time.monotonic() - self._begin

    @property
    def flown(self) -> float:
        """See :attr:`FaultCampaign.flown`."""
        return self._observer.flown

    @property
    def range_error(self) -> float:
        """See :attr:`FaultCampaign.range_error`."""
        return self._observer.range_error

    def fly(
        self, cases: Iterable[Case], *, seed: int, minutes: float, domain: int | None = None
    ) -> Campaign:
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
        compile_flight(self.configuration.controller)  # no other solver is tried
        with contextlib.ExitStack() as stack:
            self._received = stack.enter_context(signals())
            log = stack.enter_context((self._output / LOG).open("w", encoding="utf-8"))
            self._supervisor = stack.enter_context(supervised(Console(file=log), domain))
            self._connect(stack)
            self._begin = self._checked = self._sampled = time.monotonic()
            self._start_nodes()
            self._reach_orbit()
            interrupted = self.fly_cases(cases, end=60.0 * minutes)
        for words in self._resources.complaints() if self.found else ():
            self.found[-1].add(Violation("growth", words))
        latest = self._resources.latest()
        growth = {name: process.rss_percent_per_hour() for name, process in latest.items()}
        parameters = self.flight.parameters
        return self.campaign(
            seed,
            minutes=minutes,
            speed=self._speed,
            interrupted=interrupted,
            deaths=self._deaths,
            rss_growth_percent=max(filter(None, growth.values()), default=0.0),
            rss_growth_percent_by_node=growth,
            parameters={
                "asked": parameters.asked,
                "answered": parameters.answered,
                "accepted": parameters.accepted,
            },
        )

    def _connect(self, stack: contextlib.ExitStack) -> None:
        """Create the nodes of this process: one that hears, one that gives orders."""
        orbit = self.configuration.controller.orbit
        self._observer = Observer(
            limits(self.configuration), (orbit.range, orbit.altitude), self.recovery
        )
        commander = Node("campaign")
        publisher = commander.create_publisher(ORDERS.type, ORDERS.name, ORDERS.qos)
        self.flight = Flight(
            self._supervisor,
            self._observer,
            lambda text: publisher.publish(ORDERS.type(data=text)),
            ParameterClient(commander, self.configuration.controller),
            self._speed,
            REACH * orbit.range,
        )
        self._executor = EventsExecutor()
        for node in (self._observer, commander):
            self._executor.add_node(node)
            stack.callback(node.destroy_node)
        stack.callback(self._executor.shutdown)

    def _start_nodes(self) -> None:
        self._supervisor.start(RELAY, fault_relay.__name__)
        remaps = {
            node: [
                f"{topic.name}:={raw(topic).name}"  # to the relay first
                for topic in STREAMS
                if node in topic.sender
            ]
            for node in NODES
        }
        self._supervisor.start_flight(self.configuration, self._speed, remaps)

    def _reach_orbit(self) -> None:
        self.recovery.begin(0.0)
        deadline = time.monotonic() + START_LIMIT
        for _ in self._spin():
            dead = self._supervisor.dead()
            if dead or time.monotonic() > deadline:
                raise LaunchError(
                    f"the aircraft did not reach its orbit within {START_LIMIT:g} s"
                    + "".join(f"; {name} died with exit code {dead[name]}" for name in dead)
                    + f"; see {self._output / LOG}"
                )
            if self.recovery.done(self.flown) is not None:
                return

    def _spin(self) -> Iterator[None]:
        """Hear messages; yield every CHECK_PERIOD. A signal raises KeyboardInterrupt here alone.

        Within a callback, rclpy may turn that exception into others.
        """
        while True:
            self._executor.spin_once(timeout_sec=CHECK_PERIOD)
            if self._received:
                raise KeyboardInterrupt
            now = time.monotonic()
            if now - self._checked < CHECK_PERIOD:
                continue
            self._checked = now
            if now - self._sampled > SAMPLE_PERIOD:
                self._sampled = now
                self._sample(now)
            yield

    def fly_case(self, case: Case) -> CaseFindings:
        """See :meth:`FaultCampaign.fly_case`; the bag of a case that fails is kept.

        Args:
            case: To fly.
        """
        self._observer.bag.begin(time.time_ns())
        findings = super().fly_case(case)
        self._read_log(findings)
        if findings.violations:
            cases = self._output / "cases"
            cases.mkdir(exist_ok=True)
            self._observer.bag.write(cases / f"case_{case.index:04d}.mcap")
        return findings

    def watch(self, findings: CaseFindings, injections: Sequence[Injection] = ()) -> Iterator[bool]:
        """See :meth:`FaultCampaign.watch`: messages and processes."""
        moved, flown = time.monotonic(), self.flown
        for _ in self._spin():
            under_way = any(not injection.settled for injection in injections)
            if under_way or self.flown != flown:
                moved, flown = time.monotonic(), self.flown
            for violation in self._observer.take_violations():
                findings.add(violation)
            for name, code in self._supervisor.dead().items():
                self._deaths += 1
                findings.add(Violation("process lost", f"{name} ended with exit code {code}"))
                self._supervisor.restart(name)
            yield time.monotonic() - moved > STALL_LIMIT

    def _read_log(self, findings: CaseFindings) -> None:
        with (self._output / LOG).open(encoding="utf-8", errors="replace") as file:
            file.seek(self._log_read)
            text = file.read()
            self._log_read = file.tell()
        for line in text.splitlines():
            if "Traceback" in line:
                findings.add(Violation("traceback", line))

    def _sample(self, now: float) -> None:
        self._supervisor.note_shared_memory()
        self.range_errors.append((self.now(), self.range_error))
        processes = self._supervisor.processes
        self._resources.sample(now, [processes[name] for name in processes if name != RELAY])
