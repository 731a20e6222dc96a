"""When a command is due: states come at their own rate, commands keep theirs on the average."""

from __future__ import annotations


class Pace:
    """Picks the states from which a command is computed.

    Args:
        rate: Commands per second wanted; no more can come than there are states.
    """

    def __init__(self, rate: float) -> None:
        self.period = round(1e9 / rate)
        self._next: int | None = None

    def due(self, stamp: int) -> bool:
        """Whether the state of this stamp [ns] is the one to answer.

        A hundredth of the period is forgiven, so that rounding does not cost a whole state. Time
        lost is not caught up with: after a gap the pace starts anew.
        """
        if self._next is None:
            self._next = stamp
        if stamp < self._next - self.period // 100:
            return False
        self._next += self.period
        if self._next <= stamp:
            self._next = stamp + self.period
        return True

    def reset(self) -> None:
        """Forget when the last command was: the next state is due."""
        self._next = None
