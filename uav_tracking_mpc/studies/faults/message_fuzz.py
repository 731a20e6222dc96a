"""Messages by the hundred thousand, right and wrong, into the callbacks of controller and vehicle.

No middleware and no clock in between: what a seed finds, it finds again.
"""

from __future__ import annotations

import contextlib
import functools
import math
import random
import time
from collections.abc import Callable
from typing import Any

import numpy as np
import rclpy
from rclpy.signals import SignalHandlerOptions

from uav_tracking_mpc.limits._envelope import GRAVITY
from uav_tracking_mpc.nodes.conversions import (
    nanoseconds,
    set_air_velocity,
    set_command,
    set_odometry,
    set_point,
    set_stamp,
)
from uav_tracking_mpc.nodes.nmpc_controller import NmpcController
from uav_tracking_mpc.nodes.topics import AIR_VELOCITY, CLOCK, COMMAND, ODOMETRY, TARGET
from uav_tracking_mpc.nodes.uav_simulator import UavSimulator
from uav_tracking_mpc.settings.configuration import Configuration
from uav_tracking_mpc.simulation.plants.vehicle import Plant
from uav_tracking_mpc.studies.faults.fault_campaign import limits
from uav_tracking_mpc.studies.faults.invariants import ROUNDING, Invariants, Violation
from uav_tracking_mpc.studies.faults.mangling import Mangler
from uav_tracking_mpc.studies.faults.node_harness import Bench, Findings, quiet
from uav_tracking_mpc.studies.faults.observer import read_command

FLIGHT = 2000  # rounds, after which another one begins elsewhere and at another time
CALM = 250  # rounds without a wrong message after which commands must come again
EFFECT = 0.5  # s besides the dead time until a command takes effect, at most
CLOCKS = (0, 1_000_000_000, 1_700_000_000_000_000_000)  # ns; a flight begins at one of them
TIMER_SHARE = 0.01  # of the rounds in which a timer is due

Progress = Callable[[int], None]


class ControllerFuzz:
    """A controller that is flown by what arrives of the messages of vehicle and target.

    Args:
        configuration: What is flown.
        seed: Of everything random.
        findings: What it finds.
    """

    def __init__(self, configuration: Configuration, seed: int, findings: Findings) -> None:
        self._rng = random.Random(seed)
        self._configuration, self._findings = configuration, findings
        self._parameters = configuration.controller
        self._invariants = Invariants(limits(configuration))
        topics = (ODOMETRY, AIR_VELOCITY, TARGET)
        self._manglers = {topic.name: Mangler(topic.name, seed) for topic in topics}
        self._answered: Any = None  # the state that is being handed over
        self._airspeed: tuple[int, float] | None = None  # the latest that can be believed
        self._plan: tuple[np.ndarray, np.ndarray] | None = None
        self._commanded = 0
        self._bench = Bench(
            NmpcController,
            self._parameters,
            self._published,
            roots=("controller",),
            # The solver's workspace is overwritten by every solve; a doubtful state is remembered,
            # to judge the next ones.
            leaving_out=("formulation", "parameters", "_outlier", "_agreeing", "reason"),
            refusals=lambda node: node.report.refused,
            findings=findings,
            more={"use_sim_time": True},
        )

    def run(self, count: int, progress: Progress) -> None:
        """Deliver so many messages on each topic."""
        messages = self._findings.messages
        flown = 0
        while min(messages[name] for name in self._manglers) < count:
            if flown % FLIGHT == 0:
                self._take_off()
            flown += 1
            self._round()
            progress(min(messages[name] for name in self._manglers))
        self._bench.close()

    def _take_off(self) -> None:
        rng, orbit = self._rng, self._parameters.orbit
        self._plant = Plant(self._configuration.simulator)
        self._start = rng.choice(CLOCKS)
        distance, azimuth = orbit.range * rng.uniform(0.0, 3.0), rng.uniform(-math.pi, math.pi)
        self._plant.state[0] = distance * math.cos(azimuth)
        self._plant.state[1] = distance * math.sin(azimuth)
        self._plant.state[2] = orbit.altitude * rng.uniform(0.5, 1.5)
        self._plant.state[3] = rng.uniform(-math.pi, math.pi)
        self._plan = None

    def _round(self) -> None:
        rng, plant = self._rng, self._plant
        if self._plan is not None:
            with contextlib.suppress(ValueError):  # as an autopilot would
                plant.accept(*self._plan)
            self._plan = None
        plant.advance(1.0 / self._configuration.simulator.state_rate)
        stamp = self._start + round(plant.time * 1e9)
        clock = CLOCK.type()
        set_stamp(clock.clock, stamp + rng.choice((0, 1_000_000, 30_000_000)))
        self._bench.tell(CLOCK.name.lstrip("/"), clock)
        odometry, air, target = ODOMETRY.type(), AIR_VELOCITY.type(), TARGET.type()
        set_odometry(odometry, stamp, plant.state, plant.rates, plant.ground_velocity)
        set_air_velocity(air, stamp, float(plant.state[5]))
        place = np.array(self._configuration.target.position)
        if rng.random() < 0.01:  # the target below, above and in the aircraft
            place = plant.state[:3] * np.array([1.0, 1.0, rng.choice((0.0, 1.0, 2.0))])
        set_point(target, stamp, place)
        before = self._commanded
        for topic, message in ((TARGET, target), (AIR_VELOCITY, air), (ODOMETRY, odometry)):
            for arriving in self._manglers[topic.name].deliver(message):
                self._deliver(topic.name, arriving)
        self._listen(before)
        if rng.random() < TIMER_SHARE:
            self._bench.fire("_watch")
            self._bench.fire("publish")

    def _deliver(self, topic: str, message: Any) -> None:
        if topic == AIR_VELOCITY.name:
            linear = message.twist.linear
            speed = math.hypot(linear.x, linear.y, linear.z)
            sane = max(map(abs, (linear.x, linear.y, linear.z))) <= 1e3 and math.isfinite(speed)
            timed = message.header.stamp.nanosec < 10**9
            if sane and timed and message.header.frame_id == "base_link":
                self._airspeed = nanoseconds(message.header.stamp), speed
        self._answered = message if topic == ODOMETRY.name else None
        self._bench.deliver(topic, message, right=self._manglers[topic].calm > 0)
        self._answered = None

    def _listen(self, before: int) -> None:
        """After a while without a wrong message the controller must be back in command."""
        self._silent = 0 if self._commanded > before else getattr(self, "_silent", 0) + 1
        calm = min(mangler.calm for mangler in self._manglers.values())
        if calm > CALM and self._silent > CALM // 2:
            self._silent = 0
            words = f"no command for {CALM // 2} states, {calm} rounds after the last wrong message"
            self._findings.violation(Violation("silence", words))

    def _published(self, topic: str, message: Any) -> None:
        if topic != COMMAND.name:
            return
        self._commanded += 1
        plan, starts = read_command(message)
        stamp = nanoseconds(message.header.stamp)
        found = self._invariants.command(0.0, stamp * 1e-9, plan, starts)
        answered = self._answered
        if answered is None or nanoseconds(answered.header.stamp) != stamp:
            found.append(Violation("command answers", f"stamp {stamp} is not that of the state"))
        elif not found:
            found += self._turning(plan, stamp, answered)
            self._plan = plan, (stamp - self._start) * 1e-9 + starts
        for violation in found:
            self._findings.violation(violation)

    def _turning(self, plan: np.ndarray, stamp: int, state: Any) -> list[Violation]:
        """The bank limit, at the airspeed that may be left when the command takes effect."""
        ground = state.twist.twist.linear
        airspeed = math.hypot(ground.x, ground.y, ground.z)
        if self._airspeed is not None:
            age = abs(stamp - self._airspeed[0]) * 1e-9
            airspeed = self._airspeed[1] if age <= self._parameters.state_timeout else airspeed
        parameters = self._parameters
        effect = max(parameters.dead_time) + EFFECT
        left = max(airspeed + effect * parameters.acceleration_min, 1e-3)
        turning = GRAVITY * math.tan(parameters.bank_max) / left
        worst = float(np.max(np.abs(plan[:, 0])))
        if worst <= turning + ROUNDING:
            return []
        words = f"turn rate {worst:.4f} rad/s at {airspeed:.2f} m/s, bank allows {turning:.4f}"
        return [Violation("bank", words)]


class VehicleFuzz:
    """A simulated vehicle that is flown by what arrives of random commands.

    Args:
        configuration: What is flown.
        seed: Of everything random.
        findings: What it finds.
    """

    def __init__(self, configuration: Configuration, seed: int, findings: Findings) -> None:
        self._rng = np.random.default_rng(seed)
        self._findings = findings
        self._parameters = configuration.simulator
        self._mangler = Mangler(COMMAND.name, seed)
        self._now = 0
        self._bench = Bench(
            UavSimulator,
            self._parameters,
            self._published,
            roots=("_plant", "_now", "_started"),
            leaving_out=("_parameters",),
            refusals=lambda node: node._rejected,
            findings=findings,
            more={"publish_clock": True},
        )

    def run(self, count: int, progress: Progress) -> None:
        """Deliver so many commands."""
        rng = self._rng
        while self._findings.messages[COMMAND.name] < count:
            for arriving in self._mangler.deliver(self._command()):
                self._bench.deliver(COMMAND.name, arriving, right=self._mangler.calm > 0)
            # Mostly one state or two, seldom so many that nothing is left to fly.
            for _ in range(40 if rng.random() < 2e-3 else rng.integers(1, 3)):
                self._bench.fire("_step")
                self._judge()
            if rng.random() < TIMER_SHARE:
                self._bench.fire("publish")
            progress(self._findings.messages[COMMAND.name])
        self._bench.close()

    def _command(self) -> Any:
        rng, parameters = self._rng, self._parameters
        count, step = int(rng.integers(1, 6)), float(rng.choice((0.05, 0.2, 0.5, 1.0)))
        limit = 1.5 * np.array(
            [parameters.yaw_rate_max, parameters.pitch_rate_max, parameters.acceleration_max]
        )
        message = COMMAND.type()
        stamp = max(0, self._now - int(rng.integers(0, 100_000_000)))
        set_command(message, stamp, rng.uniform(-limit, limit, (count, 3)), step)
        return message

    def _judge(self) -> None:
        plant, parameters = self._bench.node._plant, self._parameters
        state, rates = plant.state, plant.rates
        if not (np.all(np.isfinite(state)) and np.all(np.isfinite(rates))):
            words = f"state {state.tolist()}, rates {rates.tolist()}"
            self._findings.violation(Violation("vehicle finite", words))
            return
        box = (parameters.yaw_rate_max, parameters.pitch_rate_max)
        slow, fast = parameters.speed_min - ROUNDING, parameters.speed_max + ROUNDING
        if np.any(np.abs(rates[:2]) > np.add(box, ROUNDING)) or not slow <= state[5] <= fast:
            words = f"rates {rates.tolist()} at {state[5]} m/s"
            self._findings.violation(Violation("vehicle limits", words))

    def _published(self, topic: str, message: Any) -> None:
        if topic == CLOCK.name:
            self._now = nanoseconds(message.clock)
        elif topic == ODOMETRY.name:
            pose, twist = message.pose.pose, message.twist.twist
            values = [
                getattr(part, axis)
                for part in (pose.position, twist.linear, twist.angular)
                for axis in "xyz"
            ]
            q = pose.orientation
            norm = math.hypot(q.x, q.y, q.z, q.w)
            if not (all(map(math.isfinite, values)) and abs(norm - 1.0) < 1e-6):
                self._findings.violation(Violation("vehicle finite", f"published {message}"))


def fuzz(
    configuration: Configuration, count: int, seed: int, progress: Callable[[str, int], None]
) -> dict[str, Any]:
    """Deliver ``count`` messages on every topic that controller and vehicle listen to.

    Args:
        configuration: What is flown.
        count: Messages on each topic.
        seed: Of everything random.
        progress: Told how far each node is.

    Returns:
        What ``--json`` prints.
    """
    findings, begin = Findings(), time.perf_counter()
    rclpy.init(args=[], signal_handler_options=SignalHandlerOptions.NO)
    try:
        quiet()
        controller = ControllerFuzz(configuration, seed, findings)
        controller.run(count, functools.partial(progress, "controller"))
        vehicle = VehicleFuzz(configuration, seed, findings)
        vehicle.run(count, functools.partial(progress, "vehicle"))
    finally:
        rclpy.try_shutdown()
    return {
        "config": configuration.name,
        "seed": seed,
        "messages": dict(findings.messages),
        "refused": dict(findings.refused),
        "exceptions": findings.exceptions,
        "violations": sum(findings.violations.values()),
        "violations_by_invariant": dict(findings.violations),
        "seconds": time.perf_counter() - begin,
        "examples": findings.examples,
    }
