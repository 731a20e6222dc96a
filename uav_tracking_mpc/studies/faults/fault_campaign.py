"""Cases one after the other: fly, strike, watch, wait for the recovery, write down."""

from __future__ import annotations

import contextlib
import tempfile
import time
from collections.abc import Iterable, Iterator
from pathlib import Path

import numpy as np
import rclpy
from rclpy.experimental.events_executor import EventsExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from rich.console import Console

from uav_tracking_mpc.launch.launcher import LaunchError
from uav_tracking_mpc.settings.configuration import Configuration
from uav_tracking_mpc.studies.faults.fault_findings import Campaign, CaseFindings
from uav_tracking_mpc.studies.faults.fault_relay import ORDERS
from uav_tracking_mpc.studies.faults.injection import Flight, Stroke, stroke
from uav_tracking_mpc.studies.faults.invariants import Limits, Violation
from uav_tracking_mpc.studies.faults.node_set import RELAY_NODE, Crew
from uav_tracking_mpc.studies.faults.observer import Observer
from uav_tracking_mpc.studies.faults.parameter_storm import ParameterStorm
from uav_tracking_mpc.studies.faults.recovery import Recovery
from uav_tracking_mpc.studies.faults.resources import Growth, usage
from uav_tracking_mpc.studies.faults.schedule import Case

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


def fly(
    configuration: Configuration,
    cases: Iterable[Case],
    *,
    seed: int,
    minutes: float,
    output: Path,
    console: Console,
) -> Campaign:
    """Fly cases until the time is over or there are no more.

    Args:
        configuration: What to fly.
        cases: In this order.
        seed: Of the cases, for the record.
        minutes: Wall time.
        output: Existing folder for the nodes' output and the bags of failing cases.
        console: Where progress goes.

    Raises:
        LaunchError: The aircraft did not reach its orbit before the first fault.
    """
    rclpy.init(args=[], signal_handler_options=SignalHandlerOptions.NO)
    with contextlib.ExitStack() as stack:
        folder = stack.enter_context(tempfile.TemporaryDirectory())
        log = stack.enter_context((output / LOG).open("w+", encoding="utf-8"))
        speed = min(SPEED, configuration.mission.speed)
        crew = Crew(configuration, speed, Path(folder) / "parameters.yaml", Console(file=log))
        stack.callback(crew.clean)
        stack.callback(rclpy.try_shutdown)
        stack.callback(crew.end)
        return _Campaign(configuration, crew, speed, output, console).run(cases, seed, minutes)


class _Campaign:
    def __init__(
        self, configuration: Configuration, crew: Crew, speed: float, output: Path, console: Console
    ) -> None:
        self._configuration, self._crew, self._speed = configuration, crew, speed
        self._output, self._console = output, console
        self._recovery = Recovery(TOLERANCE, HOLD, RECOVERY_LIMIT)
        orbit = configuration.controller.orbit
        self._observer = Observer(
            limits(configuration), (orbit.range, orbit.altitude), self._recovery
        )
        # Orders and storms come from a node of their own, as a stranger's would.
        self._stranger = Node("stranger")
        self._executor = EventsExecutor()
        self._executor.add_node(self._observer)
        self._executor.add_node(self._stranger)
        self._flight = Flight(
            crew,
            self._observer,
            self._stranger.create_publisher(ORDERS.type, ORDERS.name, ORDERS.qos),
            ParameterStorm(self._stranger, configuration.controller),
            speed,
            REACH * orbit.range,
        )
        self._begin = self._checked = self._sampled = time.monotonic()
        self._growth: dict[tuple[str, int], Growth] = {}
        self._range_errors: list[tuple[float, float]] = []
        self._deaths = 0
        self._log_read = 0

    def run(self, cases: Iterable[Case], seed: int, minutes: float) -> Campaign:
        found: list[CaseFindings] = []
        try:
            self._crew.start_all()
            self._reach_orbit()
            end = self._begin + 60.0 * minutes
            for case in cases:
                if time.monotonic() > end:
                    break
                found.append(self._fly_case(case))
                self._say(found)
        finally:
            self._executor.shutdown()
            self._observer.destroy_node()
            self._stranger.destroy_node()
        growth = self._final_growth(found)
        storm = self._flight.storm
        return Campaign(
            config=self._configuration.name,
            seed=seed,
            minutes=minutes,
            speed=self._speed,
            cases=found,
            deaths=self._deaths,
            growth=growth,
            range_errors=self._range_errors,
            storms={"asked": storm.asked, "answered": storm.answered, "accepted": storm.accepted},
        )

    def _reach_orbit(self) -> None:
        self._recovery.begin(0.0)
        deadline = time.monotonic() + START_LIMIT
        for _ in self._spin():
            dead = self._crew.dead()
            if dead or time.monotonic() > deadline:
                raise LaunchError(
                    f"the aircraft did not reach its orbit within {START_LIMIT:g} s"
                    + "".join(f"; {name} died with exit code {dead[name]}" for name in dead)
                    + f"; see {self._output / LOG}"
                )
            if self._recovery.done(self._observer.flown) is not None:
                return

    def _spin(self) -> Iterator[None]:
        """Hear messages; yield now and then for a look round."""
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
        begin = observer.flown
        pending = sorted(case.faults, key=lambda fault: fault.offset)
        strokes: list[Stroke] = []
        moved, flown = time.monotonic(), observer.flown
        ended = False
        try:
            for _ in self._spin():
                if observer.flown != flown:
                    moved, flown = time.monotonic(), observer.flown
                while pending and flown - begin >= pending[0].offset:
                    strokes.append(stroke(pending.pop(0), self._flight))
                strokes = [running for running in strokes if next(running, self) is not self]
                for violation in observer.take_violations():
                    findings.add(violation)
                self._look_for_deaths(findings)
                if strokes or (pending and time.monotonic() - moved < STALL_LIMIT):
                    moved = time.monotonic() if strokes else moved
                    continue
                if not ended:
                    ended = True
                    self._recovery.begin(flown)
                    continue
                findings.recovery = self._recovery.done(flown)
                if findings.recovery is not None and findings.recovery <= RECOVERY_LIMIT:
                    break
                stalled = time.monotonic() - moved > STALL_LIMIT
                if stalled or self._recovery.late(flown):
                    words = f"r - r_d is {observer.range_error:.1f} m after {RECOVERY_LIMIT:g} s"
                    if stalled:
                        words = f"simulated time stood still for {STALL_LIMIT:g} s"
                    findings.recovery = None
                    findings.add(Violation("recovery", words))
                    break
        finally:
            for running in strokes:
                running.close()
        self._read_log(findings)
        findings.end = time.monotonic() - self._begin
        if findings.violations:
            cases = self._output / "cases"
            cases.mkdir(exist_ok=True)
            observer.bag.write(cases / f"case_{case.index:04d}.mcap")
        return findings

    def _look_for_deaths(self, findings: CaseFindings) -> None:
        for name, code in self._crew.dead().items():
            self._deaths += 1
            findings.add(Violation("process lost", f"{name} ended with exit code {code}"))
            self._crew.start(name)

    def _read_log(self, findings: CaseFindings) -> None:
        with (self._output / LOG).open(encoding="utf-8", errors="replace") as file:
            file.seek(self._log_read)
            text = file.read()
            self._log_read = file.tell()
        for line in text.splitlines():
            if "Traceback" in line:
                findings.add(Violation("traceback", line))

    def _sample(self, now: float) -> None:
        self._crew.note_files()
        self._range_errors.append((now - self._begin, self._observer.range_error))
        for name, process in self._crew.processes.items():
            sample = usage(process.identity)
            if sample is not None and name != RELAY_NODE:
                key = (name, process.identity)
                if key not in self._growth:
                    self._growth[key] = Growth(self._crew.started[name])
                self._growth[key].add(now, sample)

    def _final_growth(self, found: list[CaseFindings]) -> dict[str, float | None]:
        """Of those that lived to the end; what any of them grew is a violation of the last case."""
        last = {
            name: self._growth[name, process.identity]
            for name, process in self._crew.processes.items()
            if (name, process.identity) in self._growth
        }
        for (name, _), growth in self._growth.items():
            words = growth.complaint()
            if words and found:
                found[-1].add(Violation("growth", f"{name}: {words}"))
        return {name: growth.rss_percent_per_hour() for name, growth in last.items()}

    def _say(self, found: list[CaseFindings]) -> None:
        case = found[-1]
        recovery = "never" if case.recovery is None else f"{case.recovery:.1f} s"
        faults = sum(len(other.kinds) for other in found)
        line = f"{case.end:6.1f} s  case {case.index:4d}  {faults:4d} faults  recovery {recovery}"
        line += "  " + ", ".join(case.kinds)
        if case.violations:
            line += "  VIOLATED: " + ", ".join(case.violations)
        self._console.print(line, highlight=False, markup=False, soft_wrap=True)
