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

"""What may be claimed of the terminal set that is flown: certified, sampled, or neither.

The checker takes half a second to load, for which a controller that comes back in flight has no
time: what belongs to it is imported where it is used.
"""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from uav_tracking_mpc.control.latest_job import LatestJob
from uav_tracking_mpc.parameters.specification import ParameterError
from uav_tracking_mpc.settings.tracking import ARTIFICIAL_ORBIT, PaperParameters
from uav_tracking_mpc.symbolic.functions import one_at_a_time

if TYPE_CHECKING:
    from uav_tracking_mpc.terminal.ingredients import StabilityProblem, TerminalIngredients

CERTIFIED, SAMPLED, NEITHER = "certified", "sampled", "neither"
BY_CONSTRUCTION = "by construction"
CONTINUABLE = (
    "every plan ends on an orbit that can be flown on, so it can always be continued while the "
    "model holds"
)


@dataclass(frozen=True)
class CertificateStatus:
    """What a controller may claim.

    Attributes:
        status: ``certified`` (a certificate covers what is flown, and the checker confirms it),
            ``sampled`` (none does, but no sample of X_f breaks the condition), ``neither``, or
            ``by construction``.
        reason: In words.
    """

    status: str
    reason: str


@one_at_a_time
def certification(parameters: PaperParameters, folder: Path) -> CertificateStatus:
    """Certified, sampled, neither, or given by construction, with the reason.

    Args:
        parameters: What is flown; with ``certificate`` set, that file counts.
        folder: Otherwise, where the certificates lie among which one may fit.

    Raises:
        ParameterError: The file of ``certificate`` cannot be read.
    """
    if parameters.terminal_constraint == ARTIFICIAL_ORBIT:
        return CertificateStatus(BY_CONSTRUCTION, CONTINUABLE)
    from uav_tracking_mpc.formulation.paper_formulation import stability_problem, terminal_level
    from uav_tracking_mpc.terminal.certificate import mismatch, read_certificate

    problem = stability_problem(parameters)
    level, ingredients, chosen = terminal_level(parameters, problem), problem.ingredients(), None
    if parameters.certificate:
        try:
            chosen = read_certificate(Path(parameters.certificate))
        except (OSError, ValueError) as error:
            raise ParameterError(
                f"parameter 'certificate' is {parameters.certificate!r}, must be a certificate "
                f"written by `uav_tracking stability`: {error}"
            ) from error
    elif level is not None:
        for path in sorted(folder.glob("*.json")):
            with contextlib.suppress(OSError, ValueError):  # a damaged one proves nothing
                content = read_certificate(path)
                if mismatch(content, problem, ingredients, level) is None:
                    chosen = content
    return certificate_status(problem, ingredients, level, chosen)


def certificate_status(
    problem: StabilityProblem,
    ingredients: TerminalIngredients,
    level: float | None,
    certificate: dict[str, Any] | None = None,
    samples: int = 20_000,
) -> CertificateStatus:
    """Judge the terminal set of a configuration.

    A certificate counts only if every parameter equals the one flown, to the last digit (P and K to
    eleven digits), and the independent checker confirms it: about a second.

    Args:
        problem: What is flown.
        ingredients: K and P_rho that are flown.
        level: varrho that is flown [-], None without a terminal set.
        certificate: A stored certificate, None if there is none.
        samples: States of X_f tried where there is no valid certificate.
    """
    from uav_tracking_mpc.terminal.certificate import mismatch, verify

    if level is None or not level > 0.0:
        return CertificateStatus(NEITHER, "no terminal set is flown")
    void = "no certificate"
    if certificate is not None:
        reason = mismatch(certificate, problem, ingredients, level) or verify(certificate)
        if reason is None:
            return CertificateStatus(CERTIFIED, f"terminal set proved at level {level:.6g}")
        void = f"certificate void: {reason}"
    broken = _sampled_violation(problem, ingredients, level, samples)
    if broken is None:
        return CertificateStatus(SAMPLED, f"{void}; {samples} samples of X_f show no violation")
    return CertificateStatus(NEITHER, f"{void}; {broken}")


def _sampled_violation(
    problem: StabilityProblem, ingredients: TerminalIngredients, level: float, samples: int
) -> str | None:
    from uav_tracking_mpc.terminal.ingredients import (
        decrease_excess,
        directions,
        input_limited_level,
    )

    try:
        allowed = input_limited_level(ingredients, *problem.deviation_bounds())
    except ValueError as error:
        return str(error)
    if allowed < level:
        return f"inputs leave U on X_f: level {level:.6g}, U allows {allowed:.6g}"
    generator = np.random.default_rng(0)
    heights = level * generator.uniform(0.0, 1.0, (samples, 1)) ** 0.4  # uniform in volume
    states = directions(ingredients.weight, samples, generator) * np.sqrt(heights)
    states[: samples // 2] *= np.sqrt(level / heights[: samples // 2])  # half of them on the edge
    values = decrease_excess(problem, ingredients)(states)
    failed = ~(values <= 0.0)
    if np.any(failed):
        return f"V_f does not fall as it must at {states[np.argmax(failed)].round(4).tolist()}"
    return None


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
        self, parameters: PaperParameters, folder: Path, report: Callable[[str], None]
    ) -> None:
        self._parameters, self._folder, self._report = parameters, folder, report
        self.claim = certification(parameters, folder)
        self._job = LatestJob("claim", self._judge)
        self._lock = threading.Lock()  # over claim and parameters, which belong together

    def change(self, parameters: PaperParameters) -> None:
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

    def _judge(self, parameters: PaperParameters) -> None:
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
