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

"""What may be claimed of the terminal set that the parameters fly."""

from __future__ import annotations

from pathlib import Path

from uav_tracking_mpc.dynamics.symbolic_work import one_at_a_time
from uav_tracking_mpc.parameters.specification import ParameterError
from uav_tracking_mpc.settings.tracking import ARTIFICIAL_ORBIT, TrackingParameters
from uav_tracking_mpc.terminal.claim import CertificateStatus

BY_CONSTRUCTION = "by construction"
WHY = (
    "every plan ends on an orbit that can be flown on, so it can always be continued while the "
    "model holds"
)


@one_at_a_time
def certification(parameters: TrackingParameters, folder: Path) -> CertificateStatus:
    """Certified, sampled, neither, or given by construction, with the reason.

    Args:
        parameters: What is flown; with ``certificate`` set, that file counts.
        folder: Otherwise, where the certificates lie among which one may fit.

    Raises:
        ParameterError: The file of ``certificate`` cannot be read.
    """
    if parameters.terminal_constraint == ARTIFICIAL_ORBIT:
        return CertificateStatus(BY_CONSTRUCTION, WHY)
    # Half a second of loading: a controller that comes back in flight has no time for it.
    from uav_tracking_mpc.formulation.paper_problem import stability_problem, terminal_level
    from uav_tracking_mpc.terminal.certificate import mismatch, read_certificate
    from uav_tracking_mpc.terminal.status import certificate_status

    problem, level = stability_problem(parameters), terminal_level(parameters)
    ingredients = problem.ingredients()
    if parameters.certificate:
        try:
            chosen = read_certificate(Path(parameters.certificate))
        except (OSError, ValueError) as error:
            raise ParameterError(
                f"parameter 'certificate' is {parameters.certificate!r}, must be a certificate "
                f"written by `uav_tracking stability`: {error}"
            ) from error
        return certificate_status(problem, ingredients, level, chosen)
    fitting = None
    if level is not None:
        for path in sorted(folder.glob("*.json")):
            content = read_certificate(path)
            if mismatch(content, problem, ingredients, level) is None:
                fitting = content
    return certificate_status(problem, ingredients, level, fitting)
