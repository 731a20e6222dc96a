"""Node ``nmpc_controller``: state, air velocity and target in, command and orbit out; managed."""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
from rclpy.clock import Clock, ClockType
from rclpy.lifecycle import LifecycleNode, LifecycleState, TransitionCallbackReturn

from uav_tracking_mpc.control.certification import certification
from uav_tracking_mpc.control.controller import Controller
from uav_tracking_mpc.control.event import Level
from uav_tracking_mpc.control.margin_check import MarginWatch
from uav_tracking_mpc.control.record import RecordingController
from uav_tracking_mpc.estimation.measurement import MeasurementError
from uav_tracking_mpc.nodes import conversions
from uav_tracking_mpc.nodes.command_wire import CommandWire
from uav_tracking_mpc.nodes.controller_report import ControllerReport
from uav_tracking_mpc.nodes.controller_views import ControllerViews
from uav_tracking_mpc.nodes.declared_parameters import declare_parameters, follow_parameters
from uav_tracking_mpc.nodes.orbit_message import orbit_message, set_orbit
from uav_tracking_mpc.nodes.peers import Promise
from uav_tracking_mpc.nodes.run import run
from uav_tracking_mpc.nodes.stall_guard import StallGuard
from uav_tracking_mpc.nodes.target_odometry import target_from_odometry
from uav_tracking_mpc.nodes.topics import (
    AIR_VELOCITY,
    COMMAND,
    ENGAGED,
    ODOMETRY,
    ORBIT,
    TARGET,
    TARGET_ODOMETRY,
)
from uav_tracking_mpc.parameters.specification import ParameterError
from uav_tracking_mpc.settings.configuration import configuration_folder
from uav_tracking_mpc.settings.tracking import TrackingParameters

STALL_MARGIN = 0.15  # s, by which the watchdog may be late without the process having stood still
SUCCESS, FAILURE = TransitionCallbackReturn.SUCCESS, TransitionCallbackReturn.FAILURE


class NmpcController(LifecycleNode):
    """Hands messages to a :class:`Controller` and publishes its commands.

    Configured and activated at the start unless ``autostart`` is false. Configuring builds and
    checks everything; while inactive it listens and sends nothing.

    Args:
        options: Those of rclpy's Node.

    Raises:
        ParameterError: With ``autostart``, parameters that cannot be flown.
    """

    def __init__(self, **options: Any) -> None:
        super().__init__("nmpc_controller", **options)
        self.parameters = declare_parameters(self, TrackingParameters, changeable=True)
        follow_parameters(self, self.parameters, self._check, self._take)
        self.controller: Controller | None = None
        self._margins: MarginWatch | None = None  # of the present controller
        self._active = False
        self._failure = ""
        self._origin: int | None = None  # first stamp seen [ns]; the controller's times are since
        self._tracked, self._both_told = -math.inf, False  # stamp of the newest target/odometry [s]
        self._arrival = -math.inf  # of the newest state that was believed, steady [s]
        self._engaged = True  # until an autopilot's link says otherwise
        self._wire, self._orbit = CommandWire(), orbit_message()
        self._views = ControllerViews(self)
        self.report = ControllerReport(self)
        simulated = bool(self.get_parameter("use_sim_time").value)
        self._promise = Promise(None if simulated else self.parameters.control_rate)
        self._commands = self.create_publisher(
            COMMAND.type,
            COMMAND.name,
            self._promise.qos(COMMAND.qos),
            event_callbacks=self._promise.callbacks(self.report.late),
        )
        self._orbits = self.create_publisher(ORBIT.type, ORBIT.name, ORBIT.qos)
        self.create_subscription(ENGAGED.type, ENGAGED.name, self._on_engaged, ENGAGED.qos)
        for topic, callback in (
            (ODOMETRY, self._on_odometry),
            (AIR_VELOCITY, self._on_air),
            (TARGET, self._on_target),
            (TARGET_ODOMETRY, self._on_target_odometry),
        ):
            heard, events = self._refusing(callback), self.report.peers.listening(topic)
            self.create_subscription(
                topic.type, topic.name, heard, topic.qos, event_callbacks=events
            )
        period = self.parameters.state_timeout / 2.0
        self._stall = StallGuard(period + STALL_MARGIN)
        self.create_timer(period, self._watch, clock=Clock(clock_type=ClockType.STEADY_TIME))
        if self.parameters.autostart:
            self.trigger_configure()
            if self.controller is None:
                raise ParameterError(self._failure)
            self.trigger_activate()

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Build and check everything; failure says why and leaves the node unconfigured.

        Args:
            state: Before the transition.
        """
        parameters = self.parameters
        try:
            claim = certification(parameters, configuration_folder() / "certificates")
            if parameters.record:
                self.controller = RecordingController(parameters, Path(parameters.record))
            else:
                self.controller = Controller(parameters)
        except (ParameterError, RuntimeError, ValueError) as error:
            self._failure = str(error)
            self.report.unconfigured(f"cannot be configured: {error}")
            return FAILURE
        self.controller.engage(self._engaged)
        self.report.configured(self.controller, claim)
        events = self.controller.events  # the next state reports them
        self._margins = MarginWatch(lambda words: events.add(Level.WARNING, words))
        self._margins.judge(parameters)
        return SUCCESS

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Answer states from now on.

        Args:
            state: Before the transition.
        """
        self._active = True
        return SUCCESS

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Send nothing from now on; the vehicle flies its plan to the end, then holds.

        Args:
            state: Before the transition.
        """
        self._active = False
        if self.controller is not None:
            self.controller.reset()
            self.controller.fall_silent("deactivated")
        self.report.tell()
        return SUCCESS

    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Forget everything; parameters may then be set that are fixed while configured.

        Args:
            state: Before the transition.
        """
        self._end_record()
        self._active, self.controller = False, None
        self.report.unconfigured("")
        return SUCCESS

    def on_shutdown(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Send nothing any more.

        Args:
            state: Before the transition.
        """
        return self.on_cleanup(state)

    def on_error(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Whatever went wrong: back to unconfigured.

        Args:
            state: Before the transition.
        """
        self.on_cleanup(state)
        self.report.unconfigured("a transition failed: unconfigured")
        return SUCCESS

    def _check(self, parameters: TrackingParameters) -> None:
        if self.controller is not None:
            self.controller.check(parameters)

    def _take(self, parameters: TrackingParameters) -> None:
        self.parameters = parameters
        if self.controller is not None:
            self.controller.change(**asdict(parameters))
            if self._margins is not None:
                self._margins.judge(parameters)
            self.report.tell()

    def _seconds(self, message: Any) -> float:
        """Stamp of a message since the first one that was seen."""
        stamp = conversions.nanoseconds(message.header.stamp)
        if self._origin is None:
            self._origin = stamp
        return (stamp - self._origin) * 1e-9

    def _refusing(self, callback: Callable[[Any, Controller], None]) -> Callable[[Any], None]:
        """The callback of a message while there is a controller; what it refuses is reported."""

        def on_message(message: Any) -> None:
            if self.controller is None:
                return
            try:
                callback(message, self.controller)
            except MeasurementError as error:
                self.report.refuse(str(error))

        return on_message

    def _on_air(self, message: Any, controller: Controller) -> None:
        airspeed = float(np.linalg.norm(conversions.air_velocity_from_twist(message)))
        controller.see_air(self._seconds(message), airspeed)

    def _on_target(self, message: Any, controller: Controller) -> None:
        position, stamp = conversions.position_from_point(message), self._seconds(message)
        if abs(stamp - self._tracked) > self.parameters.target_timeout:
            controller.see_target(stamp, position)
        elif not self._both_told:  # one after the other they would count as two measurements
            self._both_told = True
            words = "target/odometry comes as well: target/position is left out while it comes"
            self.get_logger().warning(words)

    def _on_target_odometry(self, message: Any, controller: Controller) -> None:
        measured, stamp = target_from_odometry(message), self._seconds(message)
        controller.see_target(stamp, *measured)
        self._tracked = stamp

    def _on_engaged(self, message: Any) -> None:
        self._engaged = message.data
        if self.controller is not None:
            self.controller.engage(self._engaged)

    def _on_odometry(self, message: Any, controller: Controller) -> None:
        arrival, before = time.monotonic(), controller.state_time
        fresh = self._stall.alive(arrival)
        if not self._active:
            return
        measurement = conversions.measurement_from_odometry(message, self._seconds(message))
        command = None
        if fresh:
            now = (self.get_clock().now().nanoseconds - (self._origin or 0)) * 1e-9
            command = controller.step(measurement, now)
        else:  # it was queued while the process was stopped
            controller.see_state(measurement)
        if controller.state_time != before:
            self._arrival = arrival
        if time.monotonic() - arrival > self.parameters.state_timeout:
            if command is not None:
                self.report.refuse("uav/odometry: the process was stopped while it answered")
        elif command is not None:
            stamp = conversions.nanoseconds(message.header.stamp)
            self._commands.publish(self._wire.write(stamp, command.inputs, command.step))
            self.report.command(command, (time.monotonic() - arrival) * 1e6)
            if command.flown_orbit is not None:
                set_orbit(self._orbit, stamp, command.flown_orbit)
                self._orbits.publish(self._orbit)
            self._views.publish(stamp, controller.navigator.wind, command)
        self.report.tell()

    def _watch(self) -> None:
        now = time.monotonic()
        self._stall.alive(now)
        if isinstance(self.controller, RecordingController):
            self.controller.flush()
        silent = now - self._arrival
        if self.controller is not None and self._active and silent > self.parameters.state_timeout:
            never = math.isinf(silent)
            self.controller.fall_silent("no vehicle state" if never else "vehicle state is lost")
            self.report.tell()

    def _end_record(self) -> None:
        if isinstance(self.controller, RecordingController):
            self.controller.close()

    def finish(self) -> None:
        """Publish the last diagnostics and end the record."""
        self.report.publish()
        self._end_record()


def main() -> int:
    """Entry point of the executable."""
    return run("nmpc_controller", NmpcController)


if __name__ == "__main__":
    sys.exit(main())
