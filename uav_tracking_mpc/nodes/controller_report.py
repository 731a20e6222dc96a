"""What the controller has done, as numbers for /diagnostics."""

from __future__ import annotations

import numpy as np

from uav_tracking_mpc.control.fallback import Rung
from uav_tracking_mpc.control.pilot import Command, Pilot
from uav_tracking_mpc.estimation.navigator import Navigator
from uav_tracking_mpc.estimation.situation import Situation
from uav_tracking_mpc.nodes.rate_keeper import RateKeeper
from uav_tracking_mpc.nodes.sample_window import SampleWindow
from uav_tracking_mpc.terminal.claim import CertificateStatus

LATE = 1.5  # control periods from command to command, beyond which one came late


class ControllerReport:
    """Counts and times of one controller.

    Args:
        rate: Commands a second that are asked for.

    Attributes:
        rate: Whether it is kept.
        drift: c at the last command, shape (3,), in [m/s].
        refused: Messages that could not be used.
        deadlines_missed: How often no command came for two control periods of wall time.
        flying: Whether a command has been sent.
    """

    def __init__(self, rate: float) -> None:
        self.rate = RateKeeper(rate)
        self.drift = np.zeros(3)
        self.refused = self.deadlines_missed = 0
        self.flying = False
        self._sent = self._late = self._failures = 0
        self._failure = self._decrease = ""
        self._last: float | None = None
        self._solve_times, self._response_times = SampleWindow(), SampleWindow()

    def command(self, time: float, command: Command, situation: Situation, response: float) -> None:
        """A command has been sent for the state of a time [s], ``response`` [us] after it came."""
        self._sent += 1
        self.flying = True
        if self._last is not None and 0.0 < LATE / self.rate.rate < time - self._last:
            self._late += 1
        self._last = time
        self.rate.command(time)
        self.drift = situation.drift
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

    def values(
        self, pilot: Pilot, navigator: Navigator, certification: CertificateStatus
    ) -> dict[str, object]:
        """Keys, with units, and values."""
        solve, response, ladder = self._solve_times, self._response_times, pilot.ladder
        values: dict[str, object] = {
            "rung": ladder.rung.value,
            "rung reason": ladder.reason,
            "rung changes": ladder.changes,
            "commands sent": self._sent,
            "commands late": self._late,
            "control periods missed": self.rate.missed,
            "command deadlines missed": self.deadlines_missed,
            "control rate": self.rate.complaint() or "kept",
            "plan reused": ladder.counts[Rung.EARLIER_PLAN],
            **{f"rung {rung.value}": count for rung, count in ladder.counts.items()},
            "messages refused": self.refused,
            "orbit refused": pilot.envelope.refusal(pilot.orbit, self.drift) or "no",
            "direction": pilot.orbit.direction,
            "drift east [m/s]": float(self.drift[0]),
            "drift north [m/s]": float(self.drift[1]),
            "drift up [m/s]": float(self.drift[2]),
            "target positions rejected": navigator.target.rejected,
            "target positions late": navigator.target.late,
            "target jumps": navigator.target.jumps,
            "latency [s]": float(navigator.latency),
            "solver": pilot.formulation.solver.name,
            "solves": solve.count,
            "solver failures": self._failures,
            "last failure": self._failure,
            "solve time median [us]": solve.percentile(50.0),
            "solve time p99 [us]": solve.percentile(99.0),
            "solve time max [us]": solve.max,
            "terminal set": f"{certification.status}: {certification.reason}",
            "state in to command out median [us]": response.percentile(50.0),
            "state in to command out p99 [us]": response.percentile(99.0),
            "state in to command out max [us]": response.max,
            "state in to command out": response.histogram,
        }
        decrease = pilot.formulation.decrease
        if decrease is not None:
            values["cost decrease (54) checked"] = decrease.checked
            values["cost decrease (54) failed"] = decrease.failed
            values["cost decrease (54) last reason"] = self._decrease
        return values
