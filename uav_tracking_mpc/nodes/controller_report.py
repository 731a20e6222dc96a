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

"""What the controller's node says: in the log, as /diagnostics, and on topics for people."""

from __future__ import annotations

import math
import time

import numpy as np
from geometry_msgs.msg import Point, PoseStamped
from nav_msgs.msg import Path
from numpy.typing import NDArray
from rclpy.node import Node
from visualization_msgs.msg import Marker, MarkerArray

from uav_tracking_mpc.control.certification import ClaimWatch
from uav_tracking_mpc.control.command import Command
from uav_tracking_mpc.control.commanded_path import PlannedPath
from uav_tracking_mpc.control.controller import Controller
from uav_tracking_mpc.control.event import Level
from uav_tracking_mpc.control.fallback import OWN_SOLVE, FallbackMode
from uav_tracking_mpc.dynamics.orbit import Orbit
from uav_tracking_mpc.estimation.navigator import Navigator
from uav_tracking_mpc.estimation.response_estimator import CHANNELS
from uav_tracking_mpc.mpc.bridged_solver import BridgedSolver
from uav_tracking_mpc.nodes.messages.conversions import set_header, set_orientation, set_vector
from uav_tracking_mpc.nodes.messages.diagnostic_values import (
    MODE,
    OK,
    REASON,
    controller_status,
    estimated_values,
    orbit_values,
    response_values,
)
from uav_tracking_mpc.nodes.messages.named_figures import ERRORS, set_tracking, tracking_message
from uav_tracking_mpc.nodes.ros import diagnostics
from uav_tracking_mpc.nodes.ros.diagnostics import ThrottledWarnings
from uav_tracking_mpc.nodes.ros.endpoints import PublisherWatch, publish
from uav_tracking_mpc.nodes.ros.managed_node import Stage
from uav_tracking_mpc.nodes.topics import (
    FRAMES,
    MARKERS,
    PREDICTED_PATH,
    TARGET,
    TARGET_ODOMETRY,
    TRACKING,
    TRACKING_ERRORS,
    FrameNames,
)
from uav_tracking_mpc.settings.tracking import TrackingParameters

PERIOD = 0.2  # s of wall time between paths and markers: people look at them
# us: upper ends of the bins of the histogram; the last bin is open.
BINS = (500.0, 1000.0, 2000.0, 4000.0, 10_000.0, 20_000.0, 50_000.0)


class SampleWindow:
    """The latest samples of a duration in [us].

    Args:
        size: How many count for median and percentile; maximum and histogram are over all.

    Attributes:
        count: Samples so far.
        max: Longest so far in [us].
    """

    def __init__(self, size: int = 20_000) -> None:
        self._samples = np.full(size, 0.0)  # touched now: memory must not grow in flight
        self._histogram = [0] * (len(BINS) + 1)
        self.count = 0
        self.max = 0.0

    def add(self, sample: float) -> None:
        """Take in a sample.

        Args:
            sample: Duration in [us].
        """
        self._samples[self.count % len(self._samples)] = sample
        self.count += 1
        self.max = max(self.max, sample)
        self._histogram[sum(sample >= end for end in BINS)] += 1

    def percentile(self, share: float) -> float:
        """Percentile of the latest samples in [us]; 0 before the first.

        Args:
            share: From 0 to 100, in [%].
        """
        if self.count == 0:
            return 0.0
        return float(np.percentile(self._samples[: self.count], share))

    @property
    def histogram(self) -> str:
        """Counts by duration, in words."""
        names = [f"<{end / 1e3:g} ms" for end in BINS] + [f">={BINS[-1] / 1e3:g} ms"]
        return ", ".join(
            f"{name}: {count}" for name, count in zip(names, self._histogram, strict=True) if count
        )


STAGES = {
    Stage.UNCONFIGURED: "unconfigured: no command is sent",
    Stage.INACTIVE: "inactive: no command is sent",
    Stage.ACTIVE: "active: waiting for the first state",
    Stage.FINALIZED: "shut down: no command is sent until the node is started anew",
}


class ControllerReport:
    """Counts, times, log and diagnostics of one controller.

    Args:
        node: Whose log and diagnostics they are.

    Attributes:
        alarm: Shows an error while it lasts: see :meth:`Diagnostics.alarm`.
        end: Publishes that the node has ended: see :meth:`Diagnostics.end`.
        publish: Publishes the present diagnostics: see :meth:`Diagnostics.publish`.
        peers: Who publishes what the node listens to.
        refused: Messages that could not be used.
        deadlines_missed: How often no command came for two control periods of wall time.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._claims: ClaimWatch | None = None
        self.refused = self.deadlines_missed = 0
        self._controller: Controller | None = None
        self._stage = Stage.UNCONFIGURED
        self._sent = self._failures = 0
        self._trouble = self._failure = self._decrease = ""
        self._solve_times, self._response_times = SampleWindow(), SampleWindow()
        self._diagnostics = diagnostics.Diagnostics(node, self._values)
        self.peers = PublisherWatch(
            node, lambda words: self._diagnostics.report(diagnostics.WARN, words)
        )
        self.alarm, self.end = self._diagnostics.alarm, self._diagnostics.end
        self.publish = self._diagnostics.publish
        self._throttled = ThrottledWarnings(node)

    def configured(self, controller: Controller, claims: ClaimWatch) -> None:
        """Report a controller from now on.

        Args:
            controller: Ready to fly.
            claims: What may be claimed of its terminal set.
        """
        self._controller, self._claims = controller, claims
        parameters = controller.parameters
        orbit = parameters.orbit
        self._node.get_logger().info(
            f"orbit of {orbit.range:g} m at {orbit.altitude:g} m and {orbit.speed:g} m/s, "
            f"{parameters.direction}, {parameters.model} model, N = {parameters.horizon}; "
            f"terminal set: {claims.claim.reason}"
        )

    def changed(self, parameters: TrackingParameters) -> None:
        """Report other parameters of the controller.

        Args:
            parameters: What is flown from now on.
        """
        if self._claims is not None:
            self._claims.change(parameters)
        self.tell()
        self.publish()  # what is claimed of the terminal set may hold no longer

    def at(self, stage: Stage, trouble: str) -> None:
        """Report at which stage of its life the node is.

        Args:
            stage: Where it is.
            trouble: What went wrong, in words; empty if nothing did.
        """
        self._stage, self._trouble = stage, trouble
        self._log_events()
        if stage in (Stage.UNCONFIGURED, Stage.FINALIZED):
            self._controller = None
        if trouble:
            self._diagnostics.announce(diagnostics.ERROR, trouble)
        else:
            self._diagnostics.announce(diagnostics.WARN, STAGES[stage])

    def refuse(self, words: str, topic: str = "") -> None:
        """Report a message that cannot be used.

        Args:
            words: Why.
            topic: From which it came, if it is known: each has its own throttle.
        """
        self.refused += 1
        words = f"message refused: {words}"
        if topic:
            self._throttled.warn(f"{topic} refused", words)
        else:
            self._warn("refused", words)

    def leave_out(self, topic: str, words: str) -> None:
        """Report a message that is sound and has not been used.

        Args:
            topic: From which it came.
            words: Why not.
        """
        self._warn(f"{topic} left out", f"{topic}: message left out: {words}")

    def _warn(self, subject: str, words: str) -> None:
        """Warn, now and then, of what is late; while the solver is compiled that explains it."""
        if self._controller is not None and _compiling(self._controller):
            self._node.get_logger().debug(words)
        else:
            self._throttled.warn(subject, words)

    def late(self) -> None:
        """Count that no command came in two control periods of wall time: the status tells why."""
        if self._controller is not None and self._controller.flying:
            self.deadlines_missed += 1

    def tell(self) -> None:
        """Log what has happened to the controller, and say how it is if that is news."""
        self._log_events()
        if self._controller is not None and self._stage is Stage.ACTIVE:
            self._diagnostics.report(*_status(self._controller))

    def _log_events(self) -> None:
        if self._controller is None:
            return
        for level, words in self._controller.events.take():
            if level is Level.REFUSAL:
                self.refuse(words)
            elif level is Level.INFO:
                self._node.get_logger().info(words)
            elif level is Level.WARNING:
                self._node.get_logger().warning(words)
            # The status tells of the mode: it does not change with every command.

    def stands(self) -> None:
        """Report that simulated time stands still: nothing is due, and nothing is lost."""
        if self._stage is Stage.ACTIVE:
            self._diagnostics.report(diagnostics.WARN, "simulated time stands still")

    def command(self, command: Command, response: float) -> None:
        """Count a command that has been sent.

        Args:
            command: What was sent.
            response: Time from the arrival of the state to the command in [us].
        """
        self._sent += 1
        self._response_times.add(response)
        if command.reason:
            self._failure = command.reason
        plan = command.plan
        if plan is None:
            return
        self._failures += not plan.solution.converged
        self._solve_times.add(plan.solution.solve_time * 1e6)
        if plan.decrease is not None and not plan.decrease.held:
            self._decrease = plan.decrease.reason

    def _values(self) -> dict[str, object]:
        """Keys, with units, and values."""
        controller = self._controller
        if controller is None:
            stage = {"lifecycle state": self._stage.value}
            return {**stage, "configured": False, "reason": self._trouble}
        solve, response, modes = self._solve_times, self._response_times, controller.modes
        formulation, navigator = controller.formulation, controller.navigator
        air = navigator.air_estimate if controller.parameters.air_estimation else None
        estimating = modes.mode is not FallbackMode.SILENCE
        envelope = controller.parameters.envelope
        claim = None if self._claims is None else self._claims.claim
        values: dict[str, object] = {
            "lifecycle state": self._stage.value,
            MODE: modes.mode.value,
            REASON: modes.reason,
            "mode changes": modes.changes,
            "commands sent": self._sent,
            "commands late": controller.rate.late,
            "control periods missed": controller.rate.missed,
            "command deadlines missed": self.deadlines_missed,
            "control rate": controller.rate.complaint() or "kept",
            "plan reused": modes.counts[FallbackMode.EARLIER_PLAN],
            **{f"mode {mode.value}": count for mode, count in modes.counts.items()},
            "messages refused": self.refused,
            "orbit refused": envelope.refusal(
                controller.orbit, controller.drift, navigator.target.height
            )
            or "no",
            **orbit_values(controller.orbit),
            **estimated_values(controller.drift, air, estimating),
            "target positions rejected": navigator.target.rejected,
            "target positions late": navigator.target.late,
            "target jumps": navigator.target.jumps,
            "target noise [m]": navigator.target.noise,
            "target agility [m/s^2]": navigator.target.agility,
            "latency [s]": float(navigator.latency),
            "solver": "none" if formulation is None else formulation.solver.name,
            "solves": solve.count,
            "solver failures": self._failures,
            "last failure": self._failure,
            "solve time median [us]": solve.percentile(50.0),
            "solve time p99 [us]": solve.percentile(99.0),
            "solve time max [us]": solve.max,
            "terminal set": "unknown" if claim is None else f"{claim.status}: {claim.reason}",
            "state in to command out median [us]": response.percentile(50.0),
            "state in to command out p99 [us]": response.percentile(99.0),
            "state in to command out max [us]": response.max,
            "state in to command out": response.histogram,
            **response_values(controller.response),
            **self.peers.values(),
        }
        decrease = None if formulation is None else formulation.decrease
        if decrease is not None:
            values["cost decrease (54) checked"] = decrease.checked
            values["cost decrease (54) failed"] = decrease.failed
            values["cost decrease (54) last reason"] = self._decrease
        return values


def _compiling(controller: Controller) -> bool:
    """Whether a slow solver stands in for one that is being compiled."""
    solver = None if controller.formulation is None else controller.formulation.solver
    return isinstance(solver, BridgedSolver) and solver.compiling


def _status(controller: Controller) -> tuple[bytes, str, str]:
    """Level and words of how the active controller is, and why."""
    mode, reason = controller.modes.mode, controller.modes.reason
    by_solves = reason == OWN_SOLVE if mode is FallbackMode.SILENCE else "target" not in reason
    if by_solves and _compiling(controller):
        return diagnostics.WARN, "the solver is being compiled", "a slower one solves meanwhile"
    heard = f"nothing usable comes on {TARGET.name} or {TARGET_ODOMETRY.name}"
    level, words, why = controller_status(mode, reason, controller.flying)
    if level != OK:
        if mode is FallbackMode.SILENCE and "target" in reason:
            why = heard
        elif why == "target position is lost":
            why = f"{why}, {heard}"
        return bytes([level]), words, why
    for axis, swing in enumerate(controller.response.oscillation.swings):
        if swing is not None:
            cause = controller.response.oscillation.causes[axis]  # the figures are in the values
            return diagnostics.WARN, f"limit cycle of the {CHANNELS[axis]}, likely {cause}", ""
    if controller.rate.complaint():  # the figures are in the values
        return diagnostics.WARN, "the control rate is not kept", controller.rate.complaint()
    return diagnostics.OK, words, ""


def path_message(stamp: int, states: NDArray[np.float64], frames: FrameNames = FRAMES) -> Path:
    """Path through vehicle states.

    Args:
        stamp: Of the first one in [ns].
        states: (x, y, z, psi, chi, v) in ``map``, shape (n, 6).
        frames: Of the message.
    """
    message = Path()
    set_header(message, stamp, frames.map)
    for state in states:
        pose = PoseStamped()
        pose.header = message.header
        set_vector(pose.pose.position, state[:3])
        _, _, _, heading, path_angle, _ = state.tolist()
        set_orientation(pose.pose.orientation, heading, path_angle)
        message.poses.append(pose)
    return message


def markers_message(
    stamp: int,
    states: NDArray[np.float64],
    target: NDArray[np.float64],
    orbit: Orbit,
    frames: FrameNames = FRAMES,
) -> MarkerArray:
    """Markers of target, desired orbit, plan and aircraft.

    Args:
        stamp: Of the first state in [ns].
        states: Along the plan, (x, y, z, psi, chi, v) in ``map``, shape (n, 6).
        target: Position in ``map``, shape (3,), in [m].
        orbit: What is flown.
        frames: Of the message.
    """
    angles = np.linspace(0.0, 2.0 * np.pi, 73)
    circle = target + np.column_stack(
        [
            orbit.radius * np.cos(angles),
            orbit.radius * np.sin(angles),
            np.full(len(angles), orbit.altitude),
        ]
    )
    at_target = _marker(stamp, frames.map, 0, Marker.SPHERE, (0.84, 0.37, 0.0), 6.0)
    wanted = _marker(stamp, frames.map, 1, Marker.LINE_STRIP, (0.5, 0.5, 0.5), 0.8, circle)
    plan = _marker(stamp, frames.map, 2, Marker.LINE_STRIP, (0.0, 0.45, 0.7), 1.2, states[:, :3])
    aircraft = _marker(stamp, frames.map, 3, Marker.ARROW, (0.0, 0.6, 0.5), 3.0)
    set_vector(at_target.pose.position, target)
    set_vector(aircraft.pose.position, states[0, :3])
    _, _, _, heading, path_angle, _ = states[0].tolist()
    set_orientation(aircraft.pose.orientation, heading, path_angle)
    aircraft.scale.x = 12.0
    return MarkerArray(markers=[at_target, wanted, plan, aircraft])


def _marker(
    stamp: int,
    frame: str,
    identity: int,
    kind: int,
    colour: tuple[float, float, float],
    size: float,
    points: NDArray[np.float64] | None = None,
) -> Marker:
    marker = Marker()
    set_header(marker, stamp, frame)
    marker.ns, marker.id, marker.type = "uav_tracking", identity, kind
    marker.scale.x = marker.scale.y = marker.scale.z = size
    marker.color.r, marker.color.g, marker.color.b, marker.color.a = *colour, 1.0
    for position in () if points is None else points:
        point = Point()
        set_vector(point, position)
        marker.points.append(point)
    return marker


class ControllerViews:
    """Publishes what somebody listens to.

    Args:
        node: Through which it publishes.

    Attributes:
        frames: Of the messages.
    """

    def __init__(self, node: Node) -> None:
        self._path, self._markers = (publish(node, topic) for topic in (PREDICTED_PATH, MARKERS))
        self._errors = publish(node, TRACKING_ERRORS)
        self._error_values = tracking_message()
        self._tracking = {
            name: (publish(node, topic), topic.type()) for name, topic in TRACKING.items()
        }
        self._last, self.frames = -float("inf"), FRAMES

    def publish(
        self, stamp: int, path: PlannedPath, command: Command, navigator: Navigator
    ) -> None:
        """Show one command.

        Args:
            stamp: Of the state that it answers in [ns].
            path: On which it leads.
            command: What was sent.
            navigator: What it was computed from.
        """
        present, solution = command.present, command.solution
        self._publish_errors(stamp, command, navigator)
        if solution is not None:
            self._publish_figure("cost", solution.cost)
            self._publish_figure("solve_time", solution.solve_time)
        now = time.monotonic()
        viewers = self._path.get_subscription_count() + self._markers.get_subscription_count()
        if present is not None and viewers and now - self._last >= PERIOD:
            self._last = now
            self._path.publish(path_message(stamp, path.states, self.frames))
            self._markers.publish(
                markers_message(stamp, path.states, present.target, command.orbit, self.frames)
            )

    def _publish_errors(self, stamp: int, command: Command, navigator: Navigator) -> None:
        """Stamped all in one message, and each one by itself."""
        publishers = self._errors, *(self._tracking[name][0] for name in ERRORS)
        heard = any(publisher.get_subscription_count() for publisher in publishers)
        if not heard or command.present is None:
            return
        message = self._error_values
        deviation, surplus = (
            navigator.target.track.position_std(command.stamp),
            navigator.air.surplus,
        )
        figures = deviation, navigator.wind, command.mode, surplus, self.frames
        set_tracking(message, stamp, command.present, command.orbit, *figures)
        if not all(map(math.isfinite, message.position)):
            return
        if self._errors.get_subscription_count():
            self._errors.publish(message)
        for name, error in zip(ERRORS, message.position, strict=False):
            self._publish_figure(name, error)

    def _publish_figure(self, name: str, value: float) -> None:
        publisher, message = self._tracking[name]
        if publisher.get_subscription_count():
            message.data = float(value)
            publisher.publish(message)
