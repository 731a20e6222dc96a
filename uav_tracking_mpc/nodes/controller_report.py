"""What the controller has done and how it is: in the log, and as /diagnostics."""

from __future__ import annotations

from rclpy.node import Node

from uav_tracking_mpc.control.command import Command
from uav_tracking_mpc.control.controller import Controller
from uav_tracking_mpc.control.event import Level
from uav_tracking_mpc.control.fallback import FallbackMode
from uav_tracking_mpc.estimation.channel_response import CHANNELS
from uav_tracking_mpc.nodes import diagnostics
from uav_tracking_mpc.nodes.air_values import air_values
from uav_tracking_mpc.nodes.peers import Peers
from uav_tracking_mpc.nodes.response_values import response_values
from uav_tracking_mpc.nodes.sample_window import SampleWindow
from uav_tracking_mpc.terminal.claim import CertificateStatus

WARNING_PERIOD = 5.0  # s between warnings of one kind that may come with every message


class ControllerReport:
    """Counts, times, log and diagnostics of one controller.

    Args:
        node: Whose log and diagnostics they are.

    Attributes:
        certification: What may be claimed of the terminal set; None while not configured.
        peers: Who publishes what the node listens to.
        refused: Messages that could not be used.
        deadlines_missed: How often no command came for two control periods of wall time.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self.certification: CertificateStatus | None = None
        self.refused = self.deadlines_missed = 0
        self._controller: Controller | None = None
        self._sent = self._failures = 0
        self._trouble = self._failure = self._decrease = ""
        self._solve_times, self._response_times = SampleWindow(), SampleWindow()
        self._diagnostics = diagnostics.Diagnostics(node, self._values)
        self.peers = Peers(lambda words: self._diagnostics.report(diagnostics.WARN, words))

    def configured(self, controller: Controller, certification: CertificateStatus) -> None:
        """Report a controller from now on.

        Args:
            controller: Ready to fly.
            certification: What may be claimed of its terminal set.
        """
        self._controller, self.certification = controller, certification
        parameters = controller.parameters
        orbit = parameters.orbit
        self._node.get_logger().info(
            f"orbit of {orbit.range:g} m at {orbit.altitude:g} m and {orbit.speed:g} m/s, "
            f"{parameters.direction}, {parameters.model} model, N = {parameters.horizon}; "
            f"terminal set {certification.status}: {certification.reason}"
        )

    def unconfigured(self, trouble: str) -> None:
        """Report that there is no controller.

        Args:
            trouble: What went wrong, in words; empty if nothing did.
        """
        self._controller, self._trouble = None, trouble
        if trouble:
            self._diagnostics.report(diagnostics.ERROR, trouble)

    def refuse(self, words: str) -> None:
        """Report a message that cannot be used.

        Args:
            words: Why.
        """
        self.refused += 1
        self._node.get_logger().warning(
            f"message refused: {words}", throttle_duration_sec=WARNING_PERIOD
        )

    def late(self) -> None:
        """Report that no command came in two control periods of wall time."""
        if self._controller is not None and self._controller.flying:
            self.deadlines_missed += 1
            self._node.get_logger().warning(
                "the control rate is not kept: a command is overdue",
                throttle_duration_sec=WARNING_PERIOD,
            )

    def tell(self) -> None:
        """Log what has happened to the controller, and say how it is if that is news."""
        if self._controller is None:
            return
        for level, words in self._controller.events.take():
            if level is Level.REFUSAL:
                self.refuse(words)
            elif level is Level.INFO:
                self._node.get_logger().info(words)
            else:
                self._node.get_logger().warning(words)
        self._diagnostics.report(*_status(self._controller))

    def publish(self) -> None:
        """Publish the present diagnostics."""
        self._diagnostics.publish()

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
            return {"configured": False, "reason": self._trouble}
        solve, response, modes = self._solve_times, self._response_times, controller.modes
        formulation, navigator = controller.formulation, controller.navigator
        east, north, up = controller.drift.tolist()
        envelope = controller.parameters.envelope
        claim = self.certification
        values: dict[str, object] = {
            "mode": modes.mode.value,
            "mode reason": modes.reason,
            "mode changes": modes.changes,
            "commands sent": self._sent,
            "commands late": controller.rate.late,
            "control periods missed": controller.rate.missed,
            "command deadlines missed": self.deadlines_missed,
            "control rate": controller.rate.complaint() or "kept",
            "plan reused": modes.counts[FallbackMode.EARLIER_PLAN],
            **{f"mode {mode.value}": count for mode, count in modes.counts.items()},
            "messages refused": self.refused,
            "orbit refused": envelope.refusal(controller.orbit, controller.drift) or "no",
            "direction": controller.orbit.direction,
            "drift east [m/s]": east,
            "drift north [m/s]": north,
            "drift up [m/s]": up,
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
        if controller.parameters.air_estimation:
            values |= air_values(navigator.air_filter)
        decrease = None if formulation is None else formulation.decrease
        if decrease is not None:
            values["cost decrease (54) checked"] = decrease.checked
            values["cost decrease (54) failed"] = decrease.failed
            values["cost decrease (54) last reason"] = self._decrease
        return values


def _status(controller: Controller) -> tuple[bytes, str]:
    """Level and words of how the controller is."""
    mode, reason = controller.modes.mode, controller.modes.reason
    if mode is FallbackMode.SILENCE:
        return diagnostics.WARN, f"{reason}: no command is sent"
    if mode is FallbackMode.HOLD:
        return diagnostics.ERROR, f"{reason}: wings level"
    if not mode.nominal:
        level = diagnostics.WARN if mode.planned else diagnostics.ERROR
        return level, f"flying {mode.value}, not the optimal one"
    for axis, swing in enumerate(controller.response.oscillation.swings):
        if swing is not None:
            cause = controller.response.oscillation.causes[axis]  # the figures are in the values
            return diagnostics.WARN, f"limit cycle of the {CHANNELS[axis]}, likely {cause}"
    if controller.rate.complaint():  # the figures are in the values
        return diagnostics.WARN, "the control rate is not kept"
    return diagnostics.OK, f"tracking: {mode.value}"
