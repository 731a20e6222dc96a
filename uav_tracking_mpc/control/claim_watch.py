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

"""What may be claimed of the terminal set while the orbit changes in flight."""

from __future__ import annotations

import threading
from collections.abc import Callable
from pathlib import Path

from uav_tracking_mpc.control.certification import certification
from uav_tracking_mpc.control.latest_job import LatestJob
from uav_tracking_mpc.settings.tracking import ARTIFICIAL_ORBIT, TrackingParameters
from uav_tracking_mpc.terminal.claim import NEITHER, CertificateStatus


class ClaimWatch:
    """Judges the terminal set again for every new orbit, in a thread of its own.

    That takes from a tenth of a second to seconds. Until it is done nothing is claimed.

    Args:
        parameters: What is flown at first; judged at once.
        folder: Where certificates lie.
        report: Called in that thread with each later claim in words.

    Attributes:
        claim: What may be claimed of the terminal set that is flown now.

    Raises:
        ParameterError: The file of ``certificate`` cannot be read.
    """

    def __init__(
        self, parameters: TrackingParameters, folder: Path, report: Callable[[str], None]
    ) -> None:
        self._parameters, self._folder, self._report = parameters, folder, report
        self.claim = certification(parameters, folder)
        self._job = LatestJob("claim", self._judge)
        self._lock = threading.Lock()  # over claim and parameters, which belong together

    def change(self, parameters: TrackingParameters) -> None:
        """Fly other parameters from now on; returns at once.

        Args:
            parameters: The new ones, of which no fixed one differs.
        """
        with self._lock:
            before, self._parameters = self._parameters, parameters
            built = parameters.terminal_constraint == ARTIFICIAL_ORBIT
            if built or parameters.orbit == before.orbit:
                return
            words = f"the orbit of {parameters.orbit.in_short} is new and not judged yet"
            self.claim = CertificateStatus(NEITHER, words)
        self._job.ask(parameters)

    def wait(self) -> None:
        """Return when the claim is that of the orbit that is flown."""
        self._job.wait()

    def _judge(self, parameters: TrackingParameters) -> None:
        try:
            claim = certification(parameters, self._folder)
        except (ArithmeticError, OSError, RuntimeError, ValueError) as error:
            claim = CertificateStatus(NEITHER, str(error))
        with self._lock:
            current = parameters.orbit == self._parameters.orbit
            if current:  # else a newer one waits
                self.claim = claim
        if current:
            self._report(f"terminal set {claim.status}: {claim.reason}")
