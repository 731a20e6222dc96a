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

"""Work on the latest of what is asked for, in a thread of its own."""

from __future__ import annotations

import logging
import math
import threading
import time
from collections.abc import Callable
from typing import Generic, TypeVar

logger = logging.getLogger(__name__)

T = TypeVar("T")
LOOK_PERIOD = 0.1  # s between looks at whether the program ends


class LatestJob(Generic[T]):
    """Does one thing after the other in a thread; of what waits only the latest counts.

    Args:
        name: Of the thread.
        work: Called in that thread with each thing that is asked for. An exception of its ends that
            one thing: it is logged, and the next one is done.
        patience: Delay before the first work in [s].
        rest: How long nothing else may be asked for before work begins in [s], so that a series of
            changes is worked on once.
    """

    def __init__(
        self, name: str, work: Callable[[T], None], patience: float = 0.0, rest: float = 0.0
    ) -> None:
        self._name, self._work, self._rest = name, work, rest
        self._begin = time.monotonic() + patience
        self._lock = threading.Lock()
        self._next: list[T] = []
        self._thread: threading.Thread | None = None

    def ask(self, what: T) -> None:
        """Have something done soon; returns at once.

        Args:
            what: Takes the place of what was asked for and has not begun.
        """
        with self._lock:
            self._begin = max(self._begin, time.monotonic() + self._rest)
            self._next = [what]
            if self._thread is None:
                self._thread = threading.Thread(target=self._run, name=self._name)
                self._thread.start()

    def wait(self) -> None:
        """Return when all that was asked for is done."""
        thread = self._thread
        if thread is not None:
            thread.join()

    def end(self) -> None:
        """Give up what has not begun."""
        with self._lock:
            self._next, self._begin = [], -math.inf

    def _run(self) -> None:
        while True:
            while time.monotonic() < self._begin and threading.main_thread().is_alive():
                time.sleep(LOOK_PERIOD)
            with self._lock:
                early = time.monotonic() < self._begin
                if early and threading.main_thread().is_alive():
                    continue  # it was asked for something else meanwhile
                waiting, self._next = self._next, []
                if early or not waiting:
                    self._thread = None
                    return
            try:
                self._work(*waiting)
            except Exception:
                logger.exception("work of thread %s failed", self._name)
