"""Which vehicle states are believed: an odd one is a bad message, several that agree are a fact."""

from __future__ import annotations

from enum import Enum

import numpy as np
from numpy.typing import NDArray

SPEED_LIMIT = 500.0  # m/s over ground; what moves faster has jumped
SLACK = 50.0  # m of position that no motion need explain
AGREEING = 3  # odd states in a row, each following the one before, that are a fact


class Verdict(Enum):
    """What to do with a state."""

    USE = "use"
    DROP = "drop"  # a duplicate, or out of order: nothing to say
    DOUBT = "doubt"  # odd: not used unless the next ones agree
    RESTART = "restart"  # time has gone back, or the vehicle is elsewhere: start anew


class StateGate:
    """Judges states by stamp and position.

    Args:
        timeout: Step of the stamps, either way, that is no longer ordinary, in [s].

    Attributes:
        reason: Why the last state was doubted or made a restart, in words.
    """

    def __init__(self, timeout: float) -> None:
        self.timeout = timeout
        self.reset()

    def reset(self) -> None:
        """Believe the next state, whatever it is."""
        self._newest: tuple[int, NDArray[np.float64]] | None = None
        self._odd: tuple[int, NDArray[np.float64]] | None = None
        self._agreeing = 0
        self.reason = ""

    def judge(self, stamp: int, position: NDArray[np.float64]) -> Verdict:
        """What to do with a state.

        Args:
            stamp: In [ns].
            position: In ``map``, shape (3,), in [m].
        """
        if self._newest is None:
            return self._believe(stamp, position, Verdict.USE)
        step = (stamp - self._newest[0]) * 1e-9
        if -self.timeout < step <= 0.0:
            return Verdict.DROP
        jump = float(np.linalg.norm(position - self._newest[1]))
        moved = jump > SLACK + SPEED_LIMIT * min(abs(step), self.timeout)
        if abs(step) <= self.timeout and not moved:
            return self._believe(stamp, position, Verdict.USE)
        if step < 0.0:
            self.reason = f"header.stamp went back by {-step:.3f} s"
        elif moved:
            self.reason = f"pose.position jumped by {jump:.6g} m in {step:.3f} s"
        else:
            self.reason = f"header.stamp went ahead by {step:.3f} s"
        self._agreeing = self._agreeing + 1 if self._follows(stamp, position) else 1
        self._odd = stamp, position
        if self._agreeing < AGREEING:
            return Verdict.DOUBT
        # A gap is flown on after; time gone back and a vehicle elsewhere are a new beginning.
        verdict = Verdict.RESTART if step < 0.0 or moved else Verdict.USE
        return self._believe(stamp, position, verdict)

    def _believe(self, stamp: int, position: NDArray[np.float64], verdict: Verdict) -> Verdict:
        self._newest, self._odd, self._agreeing = (stamp, position), None, 0
        return verdict

    def _follows(self, stamp: int, position: NDArray[np.float64]) -> bool:
        """Whether a state follows the odd one before it."""
        if self._odd is None:
            return False
        step = (stamp - self._odd[0]) * 1e-9
        jump = float(np.linalg.norm(position - self._odd[1]))
        return 0.0 < step <= self.timeout and jump <= SLACK + SPEED_LIMIT * step
