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

"""What can be said of the terminal set that is flown: certified, sampled, or neither."""

from __future__ import annotations

from typing import Any

import numpy as np

from uav_tracking_mpc.terminal.certificate import mismatch
from uav_tracking_mpc.terminal.claim import CERTIFIED, NEITHER, SAMPLED, CertificateStatus
from uav_tracking_mpc.terminal.ingredients import TerminalIngredients, input_limited_level
from uav_tracking_mpc.terminal.stability_problem import StabilityProblem
from uav_tracking_mpc.terminal.theorems import q_star
from uav_tracking_mpc.terminal.verify import verify
from uav_tracking_mpc.terminal.violation import Excess, directions


def certificate_status(
    problem: StabilityProblem,
    ingredients: TerminalIngredients,
    level: float | None,
    certificate: dict[str, Any] | None = None,
    samples: int = 20_000,
    seed: int = 0,
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
        seed: Of the samples.
    """
    if level is None or not level > 0.0:
        return CertificateStatus(NEITHER, "no terminal set is flown")
    void = "no certificate"
    if certificate is not None:
        reason = mismatch(certificate, problem, ingredients, level) or verify(certificate)
        if reason is None:
            return CertificateStatus(CERTIFIED, f"terminal set proved at level {level:.6g}")
        void = f"certificate void: {reason}"
    broken = _sampled_violation(problem, ingredients, level, samples, seed)
    if broken is None:
        return CertificateStatus(SAMPLED, f"{void}; {samples} samples of X_f show no violation")
    return CertificateStatus(NEITHER, f"{void}; {broken}")


def _sampled_violation(
    problem: StabilityProblem,
    ingredients: TerminalIngredients,
    level: float,
    samples: int,
    seed: int,
) -> str | None:
    try:
        allowed = input_limited_level(ingredients, *problem.deviation_bounds())
    except ValueError as error:
        return str(error)
    if allowed < level:
        return f"inputs leave U on X_f: level {level:.6g}, U allows {allowed:.6g}"
    generator = np.random.default_rng(seed)
    heights = level * generator.uniform(0.0, 1.0, (samples, 1)) ** 0.4  # uniform in volume
    states = directions(ingredients.weight, samples, generator) * np.sqrt(heights)
    states[: samples // 2] *= np.sqrt(level / heights[: samples // 2])  # half of them on the edge
    star = q_star(problem.state_weight, problem.input_weight, ingredients.gain)
    weight = ingredients.weight
    values = Excess(problem.dynamics(), ingredients.gain, weight, weight - star)(states)
    failed = ~(values <= 0.0)
    if np.any(failed):
        return f"V_f does not fall as it must at {states[np.argmax(failed)].round(4).tolist()}"
    return None
