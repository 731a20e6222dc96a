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

"""Requests of any thread, carried out by the one that owns what they change."""

from __future__ import annotations

import concurrent.futures
import queue
from collections.abc import Callable

from uav_tracking_mpc.parameters.specification import ParameterError
from uav_tracking_mpc.simulation.plants import SimulationError

PATIENCE = 10.0  # s of wall time, in which a request is answered or taken back
OVER = "the simulation has ended"

Request = Callable[[], str]
Answer = concurrent.futures.Future[str]


class RequestQueue:
    """A queue of requests, each answered with why it was refused, or nothing."""

    def __init__(self) -> None:
        self._waiting: queue.SimpleQueue[tuple[Request, Answer]] = queue.SimpleQueue()
        self._closed = False

    def ask(self, request: Request) -> str:
        """Have something done, and wait for it.

        Args:
            request: Called by the thread that serves; answers why it refuses, or raises
                ParameterError or SimulationError with the reason.

        Returns:
            Why it was refused; empty where it was done.
        """
        answer: Answer = concurrent.futures.Future()
        self._waiting.put((request, answer))
        if self._closed:
            self.serve()
        try:
            return answer.result(PATIENCE)
        except concurrent.futures.TimeoutError:
            if answer.cancel():
                return f"the simulation has not answered within {PATIENCE:g} s"
            return answer.result()

    def serve(self, wait: float = 0.0) -> None:
        """Carry out what has been asked for, in order.

        Args:
            wait: How long to wait for the first request in [s].
        """
        try:
            self._answer(*self._waiting.get(timeout=max(wait, 0.0)))
            while True:
                self._answer(*self._waiting.get_nowait())
        except queue.Empty:
            return

    def close(self) -> None:
        """Refuse what is still asked for, and all that is asked from now on."""
        self._closed = True
        self.serve()

    def _answer(self, request: Request, answer: Answer) -> None:
        if not answer.set_running_or_notify_cancel():
            return
        if self._closed:
            answer.set_result(OVER)
            return
        try:
            answer.set_result(request())
        except (ParameterError, SimulationError) as refusal:
            answer.set_result(str(refusal))
        except Exception as error:  # whatever happened, the thread that serves flies on
            answer.set_exception(error)
