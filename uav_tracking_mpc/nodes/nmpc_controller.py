"""Node ``nmpc_controller``: state and target in, command out."""

from __future__ import annotations

import sys
import time
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rclpy.clock import Clock, ClockType
from rclpy.node import Node

from uav_tracking_mpc.dynamics import vehicle
from uav_tracking_mpc.dynamics.relative import relative_state
from uav_tracking_mpc.guidance.certification import certification
from uav_tracking_mpc.guidance.controller import Command, Source, TrackingController
from uav_tracking_mpc.guidance.pace import Pace
from uav_tracking_mpc.guidance.target_filter import TargetFilter
from uav_tracking_mpc.guidance.tracking_parameters import TrackingParameters
from uav_tracking_mpc.nodes import diagnostics
from uav_tracking_mpc.nodes.conversions import (
    MessageError,
    markers_message,
    nanoseconds,
    path_message,
    position_from_point,
    set_command,
    vehicle_from_odometry,
)
from uav_tracking_mpc.nodes.declared_parameters import declare_parameters
from uav_tracking_mpc.nodes.run import run
from uav_tracking_mpc.nodes.sample_window import SampleWindow
from uav_tracking_mpc.nodes.topics import (
    COMMAND,
    MARKERS,
    ODOMETRY,
    PREDICTED_PATH,
    TARGET,
    TRACKING,
)
from uav_tracking_mpc.simulation.configuration import configuration_folder

WARNING_PERIOD = 5.0  # s
VIEW_PERIOD = 0.2  # s, wall time: people look at it


class NmpcController(Node):
    """Computes a command from every state that is due, as soon as it arrives."""

    def __init__(self, **options: Any) -> None:
        """Declare parameters, build the controller and connect; options as of rclpy's Node."""
        super().__init__("nmpc_controller", **options)
        self.parameters = declare_parameters(self, TrackingParameters)
        self._pace = Pace(self.parameters.control_rate)
        self._controller = TrackingController(self.parameters)
        self._certification = certification(
            self.parameters, configuration_folder() / "certificates"
        )
        self._decrease_reason = self._failure_reason = ""
        self._target = TargetFilter(self.parameters.target_noise, self.parameters.target_agility)
        self._last_target: NDArray[np.float64] | None = None
        self._origin: int | None = None  # first stamp seen [ns]; times below are since then
        self._control_stamp: int | None = None  # state of the last command [ns]
        self._state_stamp: int | None = None  # newest state [ns]
        self._old_stamp: int | None = None  # of a state far older than the newest [ns]
        self._state_arrival = self._view_time = -float("inf")  # steady [s]
        self._solve_times, self._response_times = SampleWindow(), SampleWindow()
        self._counts = {"sent": 0, "late": 0, "plan reused": 0, "wings level": 0, "refused": 0}

        self._command_message = COMMAND.type()
        self._outputs = {
            topic.name: self.create_publisher(topic.type, topic.name, topic.qos)
            for topic in (COMMAND, PREDICTED_PATH, MARKERS, *TRACKING.values())
        }
        self._tracking_messages = {name: topic.type() for name, topic in TRACKING.items()}
        self._diagnostics = diagnostics.Diagnostics(self, self._values)
        self.create_subscription(ODOMETRY.type, ODOMETRY.name, self._on_odometry, ODOMETRY.qos)
        self.create_subscription(TARGET.type, TARGET.name, self._on_target, TARGET.qos)
        self._watchdog = self.create_timer(
            self.parameters.state_timeout / 2.0,
            self._watch,
            clock=Clock(clock_type=ClockType.STEADY_TIME),
        )
        orbit = self.parameters.orbit
        self.get_logger().info(
            f"orbit of {orbit.range:g} m at {orbit.altitude:g} m and {orbit.speed:g} m/s, "
            f"{orbit.direction}, {self.parameters.model} model, N = {self.parameters.horizon}; "
            f"terminal set {self._certification.status}: {self._certification.reason}"
        )

    def _seconds(self, stamp: int) -> float:
        if self._origin is None:
            self._origin = stamp
        return (stamp - self._origin) * 1e-9

    def _on_target(self, message: Any) -> None:
        try:
            position = position_from_point(message)
        except MessageError as error:
            self._refuse(error)
            return
        self._target.update(self._seconds(nanoseconds(message.header.stamp)), position)

    def _on_odometry(self, message: Any) -> None:
        arrival = time.monotonic()
        try:
            state = vehicle_from_odometry(message)
        except MessageError as error:
            self._refuse(error)
            return
        stamp = nanoseconds(message.header.stamp)
        if self._state_stamp is not None and stamp <= self._state_stamp:
            limit = self.parameters.state_timeout * 1e9
            if self._state_stamp - stamp < limit:
                return  # a duplicate, or older than what is known
            # One old stamp is a bad message; two that follow each other are a clock gone back.
            follows = self._old_stamp is not None and 0 < stamp - self._old_stamp < limit
            self._old_stamp = stamp
            if not follows:
                return
            self._restart(self._state_stamp - stamp)
        self._old_stamp = None
        self._state_stamp, self._state_arrival = stamp, arrival
        if not self._pace.due(stamp):
            return
        target = self._target_at(stamp)
        if target is not None:
            self._control(stamp, arrival, state, target)

    def _restart(self, step: int) -> None:
        """Time has gone back: what was learned belongs to a time that is no more."""
        self.get_logger().warning(
            f"uav/odometry: header.stamp went back by {step * 1e-9:.3f} s, starting anew"
        )
        self._controller.reset()
        self._target.reset()
        self._pace.reset()
        self._origin = self._control_stamp = self._last_target = None

    def _target_at(self, stamp: int) -> NDArray[np.float64] | None:
        """Position of the target at a stamp, None (and said why) if it is unknown."""
        now, timeout = self._seconds(stamp), self.parameters.target_timeout
        age = None if self._target.time is None else now - self._target.time
        if age is not None and abs(age) <= timeout:
            return self._target.predict(now).position
        if age is None:
            words = "no target position"
        elif age > timeout:
            words = "target position is lost"
        else:
            # From another clock, or absurd: it must not keep the next ones out.
            self._target.reset()
            words = "target/position is stamped ahead of uav/odometry: do the clocks agree?"
        self._diagnostics.report(diagnostics.WARN, f"{words}: no command is sent")
        return None

    def _control(
        self, stamp: int, arrival: float, state: NDArray[np.float64], target: NDArray[np.float64]
    ) -> None:
        elapsed = None if self._control_stamp is None else (stamp - self._control_stamp) * 1e-9
        moved = self._last_target is not None and not np.array_equal(target, self._last_target)
        self._last_target = target
        command = self._controller.step(relative_state(state, target), elapsed, moved)
        set_command(self._command_message, stamp, command.inputs, command.step)
        self._outputs[COMMAND.name].publish(self._command_message)
        self._response_times.add((time.monotonic() - arrival) * 1e6)
        self._count(stamp, command)
        self._control_stamp = stamp
        self._publish_tracking(command)
        self._publish_view(stamp, state, target, command)
        if command.source is Source.OPTIMAL:
            self._diagnostics.report(diagnostics.OK, "tracking on optimal plans")
            return
        self._failure_reason = command.reason
        self.get_logger().warning(
            f"no optimal plan: {command.reason}", throttle_duration_sec=WARNING_PERIOD
        )
        level = diagnostics.WARN if command.source is Source.EARLIER_PLAN else diagnostics.ERROR
        self._diagnostics.report(level, f"flying {command.source.value}, not the optimal one")

    def _count(self, stamp: int, command: Command) -> None:
        self._counts["sent"] += 1
        self._counts["plan reused"] += command.source is Source.EARLIER_PLAN
        self._counts["wings level"] += command.source is Source.WINGS_LEVEL
        if self._control_stamp is not None:
            self._counts["late"] += stamp - self._control_stamp > 1.5 * self._pace.period
        self._solve_times.add(command.solution.solve_time * 1e6)
        if command.decrease is not None and not command.decrease.held:
            self._decrease_reason = command.decrease.reason

    def _publish_tracking(self, command: Command) -> None:
        values = (*command.error, command.solution.cost, command.solution.solve_time)
        for (name, message), value in zip(self._tracking_messages.items(), values, strict=True):
            publisher = self._outputs[TRACKING[name].name]
            if publisher.get_subscription_count():
                message.data = float(value)
                publisher.publish(message)

    def _publish_view(
        self, stamp: int, state: NDArray[np.float64], target: NDArray[np.float64], command: Command
    ) -> None:
        path, markers = self._outputs[PREDICTED_PATH.name], self._outputs[MARKERS.name]
        viewers = path.get_subscription_count() + markers.get_subscription_count()
        now = time.monotonic()
        if not viewers or now - self._view_time < VIEW_PERIOD:
            return
        self._view_time = now
        states = [state]
        for inputs in command.inputs:
            states.append(vehicle.advance(states[-1], inputs, command.step))
        plan = np.array(states)
        path.publish(path_message(stamp, plan))
        markers.publish(markers_message(stamp, plan, target, self.parameters.orbit))

    def _watch(self) -> None:
        age = time.monotonic() - self._state_arrival
        if age > self.parameters.state_timeout:
            words = "no vehicle state" if np.isinf(age) else "vehicle state is lost"
            self._diagnostics.report(diagnostics.WARN, f"{words}: no command is sent")

    def _refuse(self, error: MessageError) -> None:
        self._counts["refused"] += 1
        self.get_logger().warning(f"message refused: {error}", throttle_duration_sec=WARNING_PERIOD)

    def _values(self) -> dict[str, object]:
        solve, response, counts = self._solve_times, self._response_times, self._counts
        return {
            "commands sent": counts["sent"],
            "commands late": counts["late"],
            "plan reused": counts["plan reused"],
            "wings level": counts["wings level"],
            "messages refused": counts["refused"],
            "solver": self._controller.solver.name,
            "solves": solve.count,
            "solver failures": counts["plan reused"] + counts["wings level"],
            "last failure": self._failure_reason,
            "solve time median [us]": solve.percentile(50.0),
            "solve time p99 [us]": solve.percentile(99.0),
            "solve time max [us]": solve.max,
            "terminal set": f"{self._certification.status}: {self._certification.reason}",
            "cost decrease (54) checked": self._controller.decrease.checked,
            "cost decrease (54) failed": self._controller.decrease.failed,
            "cost decrease (54) last reason": self._decrease_reason,
            "state in to command out median [us]": response.percentile(50.0),
            "state in to command out p99 [us]": response.percentile(99.0),
            "state in to command out max [us]": response.max,
        }

    def finish(self) -> None:
        """Publish the last diagnostics."""
        self._diagnostics.publish()


def main() -> int:
    """Entry point of the executable."""
    return run("nmpc_controller", NmpcController)


if __name__ == "__main__":
    sys.exit(main())
