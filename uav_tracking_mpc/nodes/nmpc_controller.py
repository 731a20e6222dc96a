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
from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.node import Node
from rclpy.timer import Timer

from uav_tracking_mpc.control.certification import ClaimWatch
from uav_tracking_mpc.control.command import Command
from uav_tracking_mpc.control.commanded_path import CommandPaths
from uav_tracking_mpc.control.controller import Controller
from uav_tracking_mpc.control.event import Level
from uav_tracking_mpc.control.guidance import formulation_of
from uav_tracking_mpc.control.record import RecordingController
from uav_tracking_mpc.estimation.measurement import Measurement, MeasurementError
from uav_tracking_mpc.formulation.formulation import solver_at_once
from uav_tracking_mpc.margins.margin_check import MarginWatch
from uav_tracking_mpc.nodes.controller_report import ControllerReport, ControllerViews
from uav_tracking_mpc.nodes.messages import conversions
from uav_tracking_mpc.nodes.messages.conversions import target_from_odometry
from uav_tracking_mpc.nodes.messages.named_figures import orbit_message, set_orbit
from uav_tracking_mpc.nodes.messages.wires import CommandWire, OdometryWire
from uav_tracking_mpc.nodes.ros.declared_parameters import declare_parameters, follow_parameters
from uav_tracking_mpc.nodes.ros.diagnostics import DuplicateSenders
from uav_tracking_mpc.nodes.ros.endpoints import PacedPublisher, listen, publish, steady_timer
from uav_tracking_mpc.nodes.ros.managed_node import (
    DISENGAGED,
    CommandGate,
    ManagedNode,
    Stage,
    TransitionError,
)
from uav_tracking_mpc.nodes.ros.process import run
from uav_tracking_mpc.nodes.topics import (
    AIR_VELOCITY,
    CLOCK,
    COMMAND,
    ENGAGED,
    ODOMETRY,
    ORBIT,
    TARGET,
    TARGET_ODOMETRY,
    MessageError,
    Topic,
    frame_names,
)
from uav_tracking_mpc.parameters.specification import ParameterError
from uav_tracking_mpc.settings.configuration import configuration_folder
from uav_tracking_mpc.settings.tracking import TrackingParameters

HEARD = (ODOMETRY, AIR_VELOCITY, TARGET, TARGET_ODOMETRY)
BY_HAND = (TARGET, TARGET_ODOMETRY)  # what people publish, without a stamp
MARGIN_PATIENCE = 3.0  # s, in which a flight begins before its margins are judged
MARGIN_REST = 1.0  # s without another change, after which they are judged anew
BEGINNING = 1_000_000_000  # ns; before this zero is a time of a simulation that has just begun
DRAIN = 0.1  # s after a stop in which the queued messages arrive
STALL_MARGIN = 0.15  # s, by which the watchdog may be late without the process having stood still


class MessageTimes:
    """Times in [s] at which messages were measured, since the first stamp that was seen.

    A stamp of zero is none. People publish points by hand without one, so a target's message
    without a stamp counts as measured when it arrives. A driver that does not stamp the aircraft's
    state is broken: how old the state is must be known.

    Args:
        node: Whose clock says when a message arrives.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._origin: int | None = None
        self._told: set[Topic] = set()  # topics without stamps

    def now(self) -> float:
        """The node's clock; 0 before the first message."""
        return 0.0 if self._origin is None else (self._clock() - self._origin) * 1e-9

    def measured(self, topic: Topic, message: Any) -> float:
        """Time of a message; one of the target without a stamp is of its arrival: logged once.

        Args:
            topic: From which it came.
            message: With a header.

        Raises:
            MessageError: It has no stamp, and must have one.
        """
        stamp = conversions.nanoseconds(message.header.stamp)
        if stamp == 0 and (now := self._clock()) >= BEGINNING:
            stamp = now
            words = f"{topic.name}: header.stamp is 0"
            if topic not in BY_HAND:
                raise MessageError(f"{words}, must be when it was measured: is the driver right?")
            if topic not in self._told:
                self._told.add(topic)
                words = f"{words}: such messages count as measured when they arrive"
                self._node.get_logger().info(words)
        if self._origin is None:
            self._origin = stamp
        return (stamp - self._origin) * 1e-9

    def _clock(self) -> int:
        return int(self._node.get_clock().now().nanoseconds)


class StallGuard:
    """Notices by the wall clock that the process was stopped or starved.

    Messages that came meanwhile are delivered one after the other, oldest first. In simulated time
    nothing in them tells their age, for time itself is a message.

    Args:
        limit: Time without a call of :meth:`alive` that counts as a stop, in [s]; longer than
            the period of whatever calls it regularly.
    """

    def __init__(self, limit: float) -> None:
        self._limit, self._last, self._until = limit, math.inf, -math.inf

    def alive(self, now: float) -> bool:
        """Note that the process runs.

        Args:
            now: Time of the steady clock in [s].

        Returns:
            Whether a message that arrives now is new.
        """
        if now - self._last > self._limit:
            self._until = now + DRAIN
        self._last = now
        return now >= self._until


class NmpcController(ManagedNode):
    """Hands messages to a :class:`Controller` and publishes its commands.

    Configured and activated at the start unless ``autostart`` is false. Configuring builds and
    checks everything; while inactive it takes note of aircraft, air and target and sends nothing.

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
        self._times = MessageTimes(self)
        self._tracked, self._both_told = -math.inf, False  # stamp of the newest target/odometry [s]
        self._refused = -math.inf, ""  # when [s] a state was refused last, by the steady clock; why
        self._waiting = -math.inf  # since the newest believed state was answered, steady [s]
        self._newest = -math.inf  # stamp of that state [s]; a controller that is stopped forgets it
        self._activated = -math.inf  # when it was activated, steady [s]
        self._engaged = True  # until an autopilot's link says otherwise
        self._paths, self._states = CommandPaths(), OdometryWire()
        self._views = ControllerViews(self)
        self._name_frames()
        self.report = ControllerReport(self)
        simulated = bool(self.get_parameter("use_sim_time").value)
        alone = *HEARD, COMMAND, *((CLOCK,) if simulated else ())
        self._senders = DuplicateSenders(self, alone, self.report.alarm)
        rate = None if simulated else self.parameters.control_rate
        self._commands = PacedPublisher(self, COMMAND, rate, self.report.late)
        self._orbits = publish(self, ORBIT)
        events = SubscriptionEventCallbacks(matched=self._on_engaged_senders)
        listen(self, ENGAGED, self._on_engaged, events)
        self._consent = CommandGate(self, self._on_consent)
        callbacks = self._on_odometry, self._on_air, self._on_target, self._on_target_odometry
        for topic, callback in zip(HEARD, callbacks, strict=True):
            self.report.peers.listen(topic, self._refusing(topic, callback), topic is ODOMETRY)
        self._watchdog: Timer | None = None
        self._watch_for(self.parameters.state_timeout)
        if self.parameters.autostart:
            self.trigger_configure()
            if self.controller is None:
                raise ParameterError(self.trouble)
            self.trigger_activate()
        else:
            self.report.at(self.stage, self.trouble)

    def configure(self) -> None:
        """Build and check everything.

        Raises:
            TransitionError: The parameters cannot be flown.
        """
        parameters = self.parameters
        try:
            folder = configuration_folder() / "certificates"
            claims = ClaimWatch(parameters, folder, self.get_logger().info)
            self._name_frames()
            formulation = formulation_of(parameters, solver_at_once(self.get_logger().info))
            if parameters.record:
                path = Path(parameters.record)
                controller: Controller = RecordingController(parameters, path, formulation)
            else:
                controller = Controller(parameters, formulation)
        except (ParameterError, RuntimeError, ValueError) as error:
            raise TransitionError(str(error)) from error
        controller.engage(False)  # nothing is learnt from what it does not command
        self.controller = controller
        self.report.configured(controller, claims)
        events = controller.events  # the next state reports them
        self._margins = MarginWatch(
            lambda words: events.add(Level.WARNING, words), MARGIN_PATIENCE, MARGIN_REST
        )
        self._margins.ask(parameters)

    def activate(self) -> None:
        """Answer states from now on."""
        self._activated = time.monotonic()
        if self.controller is not None:
            self.controller.fall_silent("waiting for the next vehicle state")
            self.controller.engage(self._engaged and self._consent.engaged)

    def deactivate(self) -> None:
        """Send nothing from now on; the vehicle flies its plan to the end, then holds."""
        self._stop("deactivated")

    def _stop(self, reason: str) -> None:
        if self.controller is not None:
            self.controller.reset()
            self.controller.engage(False)
            self.controller.fall_silent(reason)

    def _on_consent(self) -> None:
        """Somebody has taken the commands away, or given them back."""
        if not self._consent.engaged:
            self._stop(DISENGAGED)
        elif self.controller is not None:
            self.controller.engage(self._engaged)
        self.report.tell()

    def release(self) -> None:
        """Forget everything; parameters may then be set that are fixed while configured."""
        self._end_record()
        if self._margins is not None:
            self._margins.end()
        self.controller = self._margins = None

    def show(self, trouble: str) -> None:
        """See :meth:`ManagedNode.show`."""
        self.report.at(self.stage, trouble)

    def _check(self, parameters: TrackingParameters) -> None:
        if self.controller is not None:
            self.controller.check(parameters)

    def _take(self, parameters: TrackingParameters) -> None:
        before, self.parameters = self.parameters, parameters
        if parameters.state_timeout != before.state_timeout:
            self._watch_for(parameters.state_timeout)
        self._commands.rate = parameters.control_rate
        if self.controller is not None:
            self.controller.change(**asdict(parameters))
            if self._margins is not None:
                self._margins.ask(parameters)
            self.report.changed(parameters)

    def _watch_for(self, timeout: float) -> None:
        """Look so often that a silence of this length in [s] is noticed."""
        if self._watchdog is not None:
            self.destroy_timer(self._watchdog)
        self._stall = StallGuard(0.5 * timeout + STALL_MARGIN)
        self._watchdog = steady_timer(self, 0.5 * timeout, self._watch)

    def _name_frames(self) -> None:
        """Write and expect the frames that the parameters name."""
        self._frames = self._views.frames = frame_names(self, self.parameters)
        self._wire, self._orbit = CommandWire(self._frames), orbit_message(self._frames)

    def _refusing(
        self, topic: Topic, callback: Callable[[Any, Controller], None]
    ) -> Callable[[Any], None]:
        """The callback of a message while there is a controller; what it refuses is reported."""

        def on_message(message: Any) -> None:
            if self.controller is None:
                return
            try:
                callback(message, self.controller)
            except MeasurementError as error:
                self.report.refuse(str(error), topic.name)
                if topic is ODOMETRY:
                    self._refused = time.monotonic(), str(error)

        return on_message

    def _on_air(self, message: Any, controller: Controller) -> None:
        velocity = conversions.air_velocity_from_twist(message, self._frames)
        stamp = self._times.measured(AIR_VELOCITY, message)
        controller.see_air(stamp, float(np.linalg.norm(velocity)))

    def _on_target(self, message: Any, controller: Controller) -> None:
        position = conversions.position_from_point(message, self._frames)
        stamp = self._times.measured(TARGET, message)
        if abs(stamp - self._tracked) > self.parameters.target_timeout:
            self._see_target(TARGET, controller, stamp, position)
        elif not self._both_told:  # one after the other they would count as two measurements
            self._both_told = True
            words = "target/odometry comes as well: target/position is left out while it comes"
            self.get_logger().warning(words)

    def _on_target_odometry(self, message: Any, controller: Controller) -> None:
        measured = target_from_odometry(message, self._frames)
        stamp = self._times.measured(TARGET_ODOMETRY, message)
        self._see_target(TARGET_ODOMETRY, controller, stamp, *measured)
        self._tracked = stamp

    def _see_target(
        self, topic: Topic, controller: Controller, stamp: float, *measured: Any
    ) -> None:
        late = controller.navigator.target.late
        if controller.see_target(stamp, *measured, now=self._times.now()):
            return
        old = controller.navigator.target.late > late
        self.report.leave_out(
            topic.name, "it is no newer than the one before" if old else "an outlier, or a jump"
        )

    def _on_engaged(self, message: Any) -> None:
        self._set_engaged(message.data)

    def _on_engaged_senders(self, event: Any) -> None:
        if event.current_count == 0:  # what an autopilot's link said is true no longer
            self._set_engaged(True)

    def _set_engaged(self, engaged: bool) -> None:
        """Take note of whether the vehicle flies the commands."""
        self._engaged = engaged
        if self.controller is not None:
            commanding = self.stage is Stage.ACTIVE and self._consent.engaged
            self.controller.engage(self._engaged and commanding)

    def _on_odometry(self, data: bytes, controller: Controller) -> None:
        message = self._states.read(data)
        arrival, before = time.monotonic(), controller.state_time
        fresh = self._stall.alive(arrival)
        stamp = self._times.measured(ODOMETRY, message)
        measurement = conversions.measurement_from_odometry(message, stamp, self._frames)
        command, now = None, self._times.now()
        active = self.stage is Stage.ACTIVE
        if fresh and active and self._consent.engaged:
            command = controller.step(measurement, now)
        else:  # it is not to be answered, or was queued while the process was stopped
            controller.see_state(measurement, now)
            if active and not self._consent.engaged:
                controller.fall_silent(DISENGAGED)
        believed = controller.state_time != before
        age = math.inf if before is None else before - stamp
        if not believed and 0.0 <= age <= self.parameters.state_timeout:
            self.report.leave_out(ODOMETRY.name, "it is no newer than the one before")
        if command is not None:
            self._send(message, controller, measurement, command, arrival)
        controller.response.learn()
        self.report.tell()
        # The time that an answer takes is none in which states are missing.
        if believed or command is not None:
            self._waiting, self._newest = time.monotonic(), stamp

    def _send(
        self,
        message: Any,
        controller: Controller,
        measurement: Measurement,
        command: Command,
        arrival: float,
    ) -> None:
        """Publish the answer to a state that arrived at a time, unless it has become old."""
        answered = conversions.nanoseconds(message.header.stamp)
        path = self._paths.path(controller, measurement, command)
        data = self._wire.write(answered, command.inputs, command.step, path)
        # Looked at last: a process may be stopped anywhere, and an old command must not follow.
        if time.monotonic() - arrival > self.parameters.state_timeout:
            self.report.refuse("uav/odometry: the process was stopped while it answered")
            return
        self._commands.publisher.publish(data)
        self.report.command(command, (time.monotonic() - arrival) * 1e6)
        if command.flown_orbit is not None:
            set_orbit(self._orbit, answered, command.flown_orbit)
            self._orbits.publish(self._orbit)
        self._views.publish(answered, path, command, controller.navigator)

    def _watch(self) -> None:
        now = time.monotonic()
        stopped = not self._stall.alive(now)
        if isinstance(self.controller, RecordingController):
            self.controller.flush()
        silent = now - max(self._waiting, self._activated)
        if self.controller is None or silent <= self.parameters.state_timeout:
            return
        if self._time_stands():
            self.report.stands()
            return
        words = "vehicle state is lost: nothing" if math.isfinite(self._waiting) else "nothing"
        when, refusal = self._refused
        why = "the own process stood still" if stopped else "its sender is late, gone or stuck"
        if time.monotonic() - when <= self.parameters.state_timeout:
            why = f"the last message was refused: {refusal}"
        self.controller.fall_silent(f"{words} usable comes on {ODOMETRY.name}: {why}")
        self.report.tell()

    def _time_stands(self) -> bool:
        """Whether no state comes because simulated time itself stands still."""
        if not self.get_parameter("use_sim_time").value:
            return False
        return abs(self._times.now() - self._newest) <= self.parameters.state_timeout

    def _end_record(self) -> None:
        if isinstance(self.controller, RecordingController):
            self.controller.close()

    def finish(self) -> None:
        """Publish the last diagnostics and end the record."""
        self.report.end()
        self._end_record()


if __name__ == "__main__":
    sys.exit(run("nmpc_controller", NmpcController))
