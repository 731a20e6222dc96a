"""Node ``nmpc_controller``: state, air velocity and target in, command out; a managed node."""

from __future__ import annotations

import sys
import time
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rclpy.clock import Clock, ClockType
from rclpy.lifecycle import LifecycleNode, LifecycleState, TransitionCallbackReturn

from uav_tracking_mpc.control.certification import certification
from uav_tracking_mpc.control.fallback import Change, Rung
from uav_tracking_mpc.control.pace import Pace
from uav_tracking_mpc.control.pilot import Command, Outlook, Pilot
from uav_tracking_mpc.estimation.air_data import AirData
from uav_tracking_mpc.estimation.navigator import Navigator
from uav_tracking_mpc.estimation.state_gate import StateGate, Verdict
from uav_tracking_mpc.nodes import diagnostics
from uav_tracking_mpc.nodes.command_wire import CommandWire
from uav_tracking_mpc.nodes.controller_report import ControllerReport
from uav_tracking_mpc.nodes.controller_views import ControllerViews
from uav_tracking_mpc.nodes.conversions import (
    MessageError,
    Motion,
    air_velocity_from_twist,
    motion_from_odometry,
    nanoseconds,
    position_from_point,
)
from uav_tracking_mpc.nodes.declared_parameters import declare_parameters, follow_parameters
from uav_tracking_mpc.nodes.peers import Peers, Promise
from uav_tracking_mpc.nodes.run import run
from uav_tracking_mpc.nodes.stall_guard import StallGuard
from uav_tracking_mpc.nodes.topics import (
    AIR_VELOCITY,
    COMMAND,
    ODOMETRY,
    TARGET,
)
from uav_tracking_mpc.parameters.specification import ParameterError
from uav_tracking_mpc.settings.configuration import configuration_folder
from uav_tracking_mpc.settings.tracking import TrackingParameters

WARNING_PERIOD = 5.0  # s
STALL_MARGIN = 0.15  # s, by which the watchdog may be late without the process having stood still
LATENCY_SHARE = 0.05  # of a new measurement in the latency that the prediction starts with


class NmpcController(LifecycleNode):
    """Answers every state that is due with a command, as soon as it arrives.

    Configured and activated at the start unless ``autostart`` is false. Configuring builds and
    checks everything; while inactive it listens and sends nothing.
    """

    def __init__(self, **options: Any) -> None:
        """Declare parameters, connect and start; options as of rclpy's Node.

        Raises:
            ParameterError: With ``autostart``, parameters that cannot be flown.
        """
        super().__init__("nmpc_controller", **options)
        self.parameters = declare_parameters(self, TrackingParameters, changeable=True)
        follow_parameters(self, TrackingParameters, self._check, self._take)
        self._pilot: Pilot | None = None
        self._active = False
        self._failure = ""
        self._wire = CommandWire()
        simulated = bool(self.get_parameter("use_sim_time").value)
        self._promise = Promise(None if simulated else self.parameters.control_rate)
        self._commands = self.create_publisher(
            COMMAND.type,
            COMMAND.name,
            self._promise.qos(COMMAND.qos),
            event_callbacks=self._promise.callbacks(self._on_late),
        )
        self._views = ControllerViews(self)
        self._report = ControllerReport(self.parameters.control_rate)
        self._forget()
        self._diagnostics = diagnostics.Diagnostics(self, self._values)
        self._peers = Peers(lambda words: self._diagnostics.report(diagnostics.WARN, words))
        for topic, callback in (
            (ODOMETRY, self._on_odometry),
            (AIR_VELOCITY, self._on_air),
            (TARGET, self._on_target),
        ):
            events = self._peers.listening(topic)
            self.create_subscription(
                topic.type, topic.name, callback, topic.qos, event_callbacks=events
            )
        self._stall = StallGuard(self.parameters.state_timeout / 2.0 + STALL_MARGIN)
        self._watchdog = self.create_timer(
            self.parameters.state_timeout / 2.0,
            self._watch,
            clock=Clock(clock_type=ClockType.STEADY_TIME),
        )
        if self.parameters.autostart:
            self.trigger_configure()
            if self._pilot is None:
                raise ParameterError(self._failure)
            self.trigger_activate()

    def _forget(self) -> None:
        """Nothing has been received yet."""
        self._gate = StateGate(self.parameters.state_timeout)
        self._air = AirData(self.parameters.state_timeout)
        self._pace = Pace(self.parameters.control_rate)
        self._origin: int | None = None  # first stamp seen [ns]; times below are since then
        self._state_time: float | None = None  # of the newest state [s]
        self._state_arrival = -float("inf")  # steady [s]

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Build and check everything; failure says why and leaves the node unconfigured."""
        try:
            self._pilot = Pilot(self.parameters)
            self._navigator = Navigator(self.parameters)
            self._certification = certification(
                self.parameters, configuration_folder() / "certificates"
            )
        except (ParameterError, RuntimeError, ValueError) as error:
            self._pilot = None
            self._failure = str(error)
            self._diagnostics.report(diagnostics.ERROR, f"cannot be configured: {error}")
            return TransitionCallbackReturn.FAILURE
        self._forget()
        parameters, claim = self.parameters, self._certification
        orbit = parameters.orbit
        self.get_logger().info(
            f"orbit of {orbit.range:g} m at {orbit.altitude:g} m and {orbit.speed:g} m/s, "
            f"{parameters.direction}, {parameters.model} model, N = {parameters.horizon}; "
            f"terminal set {claim.status}: {claim.reason}"
        )
        return TransitionCallbackReturn.SUCCESS

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Answer states from now on."""
        if self._pilot is not None:
            self._pilot.reset()
        self._active = True
        return TransitionCallbackReturn.SUCCESS

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Send nothing from now on; the vehicle flies its plan to the end, then holds."""
        self._active = self._report.flying = False
        self._fall_silent("deactivated")
        return TransitionCallbackReturn.SUCCESS

    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Forget everything; parameters may then be set that are fixed while configured."""
        self._active, self._pilot = False, None
        return TransitionCallbackReturn.SUCCESS

    def on_shutdown(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Send nothing any more."""
        return self.on_cleanup(state)

    def on_error(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Whatever went wrong: back to unconfigured."""
        self._diagnostics.report(diagnostics.ERROR, "a transition failed: unconfigured")
        return self.on_cleanup(state)

    def _check(self, parameters: TrackingParameters) -> None:
        if self._pilot is None:
            return
        self._pilot.check(parameters)
        drift = self._report.drift
        refusal = parameters.envelope.refusal(parameters.orbit, drift)
        if refusal:
            raise ParameterError(f"parameters 'range', 'altitude', 'airspeed': {refusal}")

    def _take(self, parameters: TrackingParameters) -> None:
        self.parameters = parameters
        if self._pilot is None:
            return
        self._pilot.change(parameters)
        self._navigator.change(parameters)
        self._gate.timeout = self._air.timeout = parameters.state_timeout
        self._pace = Pace(parameters.control_rate)
        self._report.rate.rate = parameters.control_rate
        orbit = self.parameters.orbit
        self.get_logger().info(
            f"from now on {orbit.range:g} m at {orbit.altitude:g} m and {orbit.speed:g} m/s, "
            f"{parameters.direction}"
        )

    def _seconds(self, stamp: int) -> float:
        if self._origin is None:
            self._origin = stamp
        return (stamp - self._origin) * 1e-9

    def _on_air(self, message: Any) -> None:
        try:
            velocity = air_velocity_from_twist(message)
        except MessageError as error:
            self._refuse(error)
            return
        self._air.take(nanoseconds(message.header.stamp), float(np.linalg.norm(velocity)))

    def _on_target(self, message: Any) -> None:
        if self._pilot is None:
            return
        try:
            position = position_from_point(message)
            now = self._seconds(nanoseconds(message.header.stamp))
            self._check_target_stamp(now)
        except MessageError as error:
            self._refuse(error)
            return
        self._navigator.see_target(now, position)

    def _check_target_stamp(self, now: float) -> None:
        lead = 0.0 if self._state_time is None else now - self._state_time
        if lead > self.parameters.target_timeout:
            raise MessageError(
                f"target/position: header.stamp is {lead:.3f} s ahead of uav/odometry, may be "
                f"{self.parameters.target_timeout:g} s: do the clocks agree?"
            )

    def _on_odometry(self, message: Any) -> None:
        arrival = time.monotonic()
        fresh = self._stall.alive(arrival)
        if self._pilot is None or not self._active:
            return
        try:
            motion = motion_from_odometry(message)
        except MessageError as error:
            self._refuse(error)
            return
        stamp = nanoseconds(message.header.stamp)
        verdict = self._gate.judge(stamp, motion.position)
        if verdict is Verdict.DROP:
            return
        if verdict is Verdict.DOUBT:
            self._refuse(f"uav/odometry: {self._gate.reason}; used if the next ones agree")
            return
        if verdict is Verdict.RESTART:
            self._restart()
        self._state_time, self._state_arrival = self._seconds(stamp), arrival
        if not fresh:
            return
        self._report.rate.state(self._state_time)
        if self._pace.due(stamp):
            self._control(stamp, arrival, motion)

    def _restart(self) -> None:
        """What was learned belongs to a time or a place that is no more."""
        self.get_logger().warning(f"uav/odometry: {self._gate.reason}, starting anew")
        assert self._pilot is not None
        self._pilot.reset()
        self._navigator.reset()
        self._pace.reset()
        self._air.reset()
        self._report.rate.reset()
        self._origin = None

    def _control(self, stamp: int, arrival: float, motion: Motion) -> None:
        assert self._pilot is not None
        now, navigator = self._seconds(stamp), self._navigator
        seen = navigator.target.time
        state = self._air.vehicle_state(stamp, motion, self.get_logger())
        if seen is None or seen - now > self.parameters.target_timeout:
            navigator.target.reset()
            self._without_target(stamp, now, state)
            return
        turn_rates = (motion.turn_rate, motion.path_angle_rate)
        fresh = now - seen <= self.parameters.target_timeout
        try:
            situation = navigator.situation(now, state, motion.ground_velocity, turn_rates)
            outlook = Outlook(*navigator.at_effect(now, situation), fresh)
        except (ArithmeticError, ValueError) as error:
            # No state that passes the checks should lead here; the aircraft is not lost over it.
            trouble = f"the navigation failed: {error}"
            self._send(stamp, now, self._pilot.hold(now, state, trouble))
            self._diagnostics.report(diagnostics.ERROR, f"{trouble}: wings level")
            return
        command = self._pilot.step(now, outlook)
        taken = time.monotonic() - arrival
        if taken > self.parameters.state_timeout:
            self._refuse(
                f"uav/odometry: answered only after {taken:.3f} s, the command is not sent"
            )
            return
        self._send(stamp, now, command)
        late = max(0.0, (self.get_clock().now().nanoseconds - stamp) * 1e-9)
        navigator.latency += LATENCY_SHARE * (min(late, 1.0) - navigator.latency)
        self._report.command(now, command, situation, (time.monotonic() - arrival) * 1e6)
        self._views.publish(stamp, state, situation.target, navigator.wind, command)
        self._diagnose(command)

    def _send(self, stamp: int, now: float, command: Command) -> None:
        self._commands.publish(self._wire.write(stamp, command.inputs, command.step))
        self._navigator.commanded(now, command.inputs, command.step)
        self._announce(command.change)

    def _without_target(self, stamp: int, now: float, state: NDArray[np.float64]) -> None:
        """Before the first target nothing is sent; in flight the wings are held level."""
        assert self._pilot is not None
        trouble = "no target position"
        if not self._report.flying:
            self._fall_silent(trouble)
            return
        self._send(stamp, now, self._pilot.hold(now, state, trouble))
        self._diagnostics.report(diagnostics.ERROR, f"{trouble}: wings level")

    def _announce(self, change: Change | None) -> None:
        """Every step on the ladder is said once."""
        if change is None:
            return
        if change.after is Rung.OPTIMAL:
            self.get_logger().info(str(change))
        else:
            self.get_logger().warning(str(change))

    def _diagnose(self, command: Command) -> None:
        if command.rung is not Rung.OPTIMAL:
            level = diagnostics.WARN if command.rung.planned else diagnostics.ERROR
            self._diagnostics.report(level, f"flying {command.rung.value}, not the optimal one")
            return
        if self._report.rate.complaint():  # the figures are in the values
            self._diagnostics.report(diagnostics.WARN, "the control rate is not kept")
            return
        self._diagnostics.report(diagnostics.OK, "tracking on optimal plans")

    def _fall_silent(self, trouble: str) -> None:
        assert self._pilot is not None
        change = self._pilot.fall_silent(trouble)
        self._announce(change)
        self._diagnostics.report(diagnostics.WARN, f"{trouble}: no command is sent")

    def _on_late(self) -> None:
        """No command in two control periods of wall time; told once with what else is."""
        if self._active and self._report.flying:
            self._report.deadlines_missed += 1
            self.get_logger().warning(
                "the control rate is not kept: a command is overdue",
                throttle_duration_sec=WARNING_PERIOD,
            )

    def _watch(self) -> None:
        self._stall.alive(time.monotonic())
        if self._pilot is None or not self._active:
            return
        age = time.monotonic() - self._state_arrival
        if age > self.parameters.state_timeout:
            self._fall_silent("no vehicle state" if np.isinf(age) else "vehicle state is lost")

    def _refuse(self, error: MessageError | str) -> None:
        self._report.refused += 1
        self.get_logger().warning(f"message refused: {error}", throttle_duration_sec=WARNING_PERIOD)

    def _values(self) -> dict[str, object]:
        if self._pilot is None:
            return {"configured": False, "reason": self._failure}
        return {
            **self._report.values(self._pilot, self._navigator, self._certification),
            **self._peers.values(),
        }

    def finish(self) -> None:
        """Publish the last diagnostics."""
        self._diagnostics.publish()


def main() -> int:
    """Entry point of the executable."""
    return run("nmpc_controller", NmpcController)


if __name__ == "__main__":
    sys.exit(main())
