"""Whether this process has been standing still: what is heard first after that is old."""

from __future__ import annotations

DRAIN = 0.1  # s in which what has piled up meanwhile is heard


class StallGuard:
    """Notices by the wall clock that the process was stopped or starved.

    Messages that came meanwhile are handed over one after the other, oldest first, and nothing in
    them tells their age when time itself is a message.

    Args:
        limit: Time without a sign of life that is no longer ordinary, in [s]; longer than the
            period of whatever calls :meth:`alive` regularly.
    """

    def __init__(self, limit: float) -> None:
        self._limit = limit
        self._last: float | None = None
        self._until = -float("inf")
        self.stalls = 0

    def alive(self, now: float) -> bool:
        """Sign of life at a time of the steady clock [s].

        Returns:
            Whether what is heard now can be trusted to be news.
        """
        if self._last is not None and now - self._last > self._limit:
            self._until = now + DRAIN
            self.stalls += 1
        self._last = now
        return now >= self._until
