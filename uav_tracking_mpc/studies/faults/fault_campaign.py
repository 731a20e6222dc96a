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

"""Cases one after the other: fly, inject, watch, wait for the recovery, write down."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np
from rclpy.experimental.events_executor import EventsExecutor
from rclpy.node import Node
from rich.console import Console

from uav_tracking_mpc.control.compiled_flight import compile_flight
from uav_tracking_mpc.launch.supervisor import NODES, LaunchError, supervised
from uav_tracking_mpc.settings.configuration import Configuration
from uav_tracking_mpc.studies.faults import fault_relay
from uav_tracking_mpc.studies.faults.fault_findings import Campaign, CaseFindings
from uav_tracking_mpc.studies.faults.injected_flight import Flight
from uav_tracking_mpc.studies.faults.injection import Injection
from uav_tracking_mpc.studies.faults.invariants import Limits, Violation
from uav_tracking_mpc.studies.faults.kinds import Fault
from uav_tracking_mpc.studies.faults.observer import Observer
from uav_tracking_mpc.studies.faults.parameter_client import ParameterClient
from uav_tracking_mpc.studies.faults.recovery import Recovery
from uav_tracking_mpc.studies.faults.resources import ResourceWatch
from uav_tracking_mpc.studies.faults.schedule import Case
from uav_tracking_mpc.studies.faults.streams import STREAMS

SPEED = 5.0  # simulated over wall time, at most: five processes share the cores
TOLERANCE = 10.0  # m of range and altitude error on the orbit
HOLD = 2.0  # s of simulated time that the orbit must be held
RECOVERY_LIMIT = 30.0  # s of simulated time
STALL_LIMIT = 20.0  # s of wall time in which simulated time must move on
START_LIMIT = 120.0  # s of wall time to fly onto the orbit the first time
TRANSPORT = 0.5  # s of wall time that messages may take, whatever the load
FENCE = 3.0  # times the distance at the start
REACH = 1.0  # times the range: how far a target is teleported
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


class FaultCampaign:
    """A campaign with real nodes.

    Args:
        configuration: What to fly.
        faults: That the cases name, by label.
        output: Existing folder for the nodes' output and the bags of failing cases.
        console: Where progress goes.
    """

    def __init__(
        self,
        configuration: Configuration,
        faults: Mapping[str, Fault],
        output: Path,
        console: Console,
    ) -> None:
        self._configuration, self._faults = configuration, faults
        self._output, self._console = output, console
        self._speed = min(SPEED, configuration.mission.speed)
        self._recovery = Recovery(TOLERANCE, HOLD, RECOVERY_LIMIT)
        self._resources = ResourceWatch()
        self._range_errors: list[tuple[float, float]] = []
        self._deaths = 0
        self._log_read = 0

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
        compile_flight(self._configuration.controller)  # no other solver is tried
        with contextlib.ExitStack() as stack:
            log = stack.enter_context((self._output / LOG).open("w", encoding="utf-8"))
            self._supervisor = stack.enter_context(supervised(Console(file=log), domain))
            self._connect(stack)
            self._begin = self._checked = self._sampled = time.monotonic()
            self._start_nodes()
            self._reach_orbit()
            found: list[CaseFindings] = []
            interrupted = False
            end = self._begin + 60.0 * minutes
            try:
                for case in cases:
                    if time.monotonic() > end:
                        break
                    found.append(self._fly_case(case))
                    self._report(found)
            except KeyboardInterrupt:
                if not found:
                    raise
                interrupted = True
        for words in self._resources.complaints() if found else ():
            found[-1].add(Violation("growth", words))
        parameters = self._flight.parameters
        return Campaign(
            config=self._configuration.name,
            seed=seed,
            minutes=minutes,
            speed=self._speed,
            interrupted=interrupted,
            cases=found,
            families={label: fault.family for label, fault in self._faults.items()},
            deaths=self._deaths,
            growth={
                name: growth.rss_percent_per_hour()
                for name, growth in self._resources.latest().items()
            },
            range_errors=self._range_errors,
            storms={
                "asked": parameters.asked,
                "answered": parameters.answered,
                "accepted": parameters.accepted,
            },
        )

    def _connect(self, stack: contextlib.ExitStack) -> None:
        """Create the nodes of this process: one that hears, one that gives orders."""
        orbit = self._configuration.controller.orbit
        self._observer = Observer(
            limits(self._configuration), (orbit.range, orbit.altitude), self._recovery
        )
        commander = Node("campaign")
        orders = fault_relay.ORDERS
        publisher = commander.create_publisher(orders.type, orders.name, orders.qos)
        self._flight = Flight(
            self._supervisor,
            self._observer,
            lambda text: publisher.publish(orders.type(data=text)),
            ParameterClient(commander, self._configuration.controller),
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
                f"{topic.name}:={fault_relay.raw(topic).name}"  # to the relay first
                for topic in STREAMS
                if node in topic.sender
            ]
            for node in NODES
        }
        self._supervisor.start_flight(self._configuration, self._speed, remaps)

    def _reach_orbit(self) -> None:
        self._recovery.begin(0.0)
        deadline = time.monotonic() + START_LIMIT
        for _ in self._spin():
            dead = self._supervisor.dead()
            if dead or time.monotonic() > deadline:
                raise LaunchError(
                    f"the aircraft did not reach its orbit within {START_LIMIT:g} s"
                    + "".join(f"; {name} died with exit code {dead[name]}" for name in dead)
                    + f"; see {self._output / LOG}"
                )
            if self._recovery.done(self._observer.flown) is not None:
                return

    def _spin(self) -> Iterator[None]:
        """Hear messages; yield every CHECK_PERIOD."""
        while True:
            self._executor.spin_once(timeout_sec=CHECK_PERIOD)
            now = time.monotonic()
            if now - self._checked < CHECK_PERIOD:
                continue
            self._checked = now
            if now - self._sampled > SAMPLE_PERIOD:
                self._sampled = now
                self._sample(now)
            yield

    def _fly_case(self, case: Case) -> CaseFindings:
        findings = CaseFindings(case.index, case.kinds, time.monotonic() - self._begin)
        observer = self._observer
        observer.bag.begin(time.time_ns())
        injections: list[Injection] = []
        try:
            self._inject(case, injections, findings)
            self._recovery.begin(observer.flown)
            self._recover(findings)
        finally:
            for injection in injections:
                injection.end()
        self._read_log(findings)
        findings.end = time.monotonic() - self._begin
        if findings.violations:
            cases = self._output / "cases"
            cases.mkdir(exist_ok=True)
            observer.bag.write(cases / f"case_{case.index:04d}.mcap")
        return findings

    def _inject(self, case: Case, injections: list[Injection], findings: CaseFindings) -> None:
        """Begin each fault at its time; return when all have settled, or time stands still."""
        begin = self._observer.flown
        pending = sorted(case.faults, key=lambda fault: fault.offset)
        for stalled in self._watch(findings, injections):
            while pending and self._observer.flown - begin >= pending[0].offset:
                scheduled = pending.pop(0)
                fault = self._faults[scheduled.label]
                injections.append(
                    Injection(fault, scheduled.duration, scheduled.seed, self._flight)
                )
            running = [injection for injection in injections if not injection.settled]
            for injection in running:
                for violation in injection.step():
                    findings.add(violation)
            if not running and (stalled or not pending):
                return

    def _recover(self, findings: CaseFindings) -> None:
        """Wait until the aircraft is back on its orbit, or will not be."""
        recovery, observer = self._recovery, self._observer
        for stalled in self._watch(findings):
            findings.recovery = recovery.done(observer.flown)
            if findings.recovery is not None and findings.recovery <= RECOVERY_LIMIT:
                return
            if stalled or recovery.late(observer.flown):
                words = f"r - r_d is {observer.range_error:.1f} m after {RECOVERY_LIMIT:g} s"
                if stalled:
                    words = f"simulated time stood still for {STALL_LIMIT:g} s"
                findings.recovery = None
                findings.add(Violation("recovery", words))
                return

    def _watch(
        self, findings: CaseFindings, injections: Sequence[Injection] = ()
    ) -> Iterator[bool]:
        """Hear and judge messages and processes; yield whether simulated time stands still.

        Under a fault it may stand still.
        """
        moved, flown = time.monotonic(), self._observer.flown
        for _ in self._spin():
            under_way = any(not injection.settled for injection in injections)
            if under_way or self._observer.flown != flown:
                moved, flown = time.monotonic(), self._observer.flown
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
        self._range_errors.append((now - self._begin, self._observer.range_error))
        processes = self._supervisor.processes
        self._resources.sample(now, [processes[name] for name in processes if name != RELAY])

    def _report(self, found: list[CaseFindings]) -> None:
        case = found[-1]
        recovery = "never" if case.recovery is None else f"{case.recovery:.1f} s"
        faults = sum(len(other.kinds) for other in found)
        line = f"{case.end:6.1f} s  case {case.index:4d}  {faults:4d} faults  recovery {recovery}"
        line += "  " + ", ".join(case.kinds)
        if case.violations:
            line += "  VIOLATED: " + ", ".join(case.violations)
        self._console.print(line, highlight=False, markup=False, soft_wrap=True)
