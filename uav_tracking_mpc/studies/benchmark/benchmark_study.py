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

"""All cases of the benchmark as one object."""

from __future__ import annotations

import platform
import time
from typing import Any

from rich.console import Console

from uav_tracking_mpc.studies.benchmark.acados_peer import acados_peers
from uav_tracking_mpc.studies.benchmark.cases import cases, paper_case
from uav_tracking_mpc.studies.benchmark.solver_timing import (
    OURS,
    all_solvers,
    horizon_sweep,
    measure,
    missions_per_second,
    summary,
)

MISSION_STEPS = 150
HORIZONS = [5, 10, 20, 30, 50, 100]


def benchmark(
    *,
    cold: int = 2000,
    peers_cold: int = 20,
    seed: int = 0,
    quick: bool = False,
    acados: str | None = None,
) -> dict[str, Any]:
    """Run all cases; what runs is said on stderr.

    Args:
        cold: Random cold starts for ours.
        peers_cold: How many of them the peers solve as well.
        seed: Of the random states.
        acados: Python that has acados_template; None to go without this peer.
        quick: At most 50 cold starts, 5 for the peers, 2 transients, and no sweep of the horizon.

    Returns:
        ``cases.<case>.<solver>`` as
        :func:`uav_tracking_mpc.studies.benchmark.solver_timing.summary`, with the ratios of
        the medians to ours (``ratios``: each solver alone; ``ratios_alternating``: in turns at
        every step), missions a second, the sweep of the horizon, and the duration.
    """
    begin = time.perf_counter()
    if quick:
        cold, peers_cold = min(cold, 50), min(peers_cold, 5)
    results: dict[str, Any] = {
        "seed": seed,
        "machine": platform.processor() or platform.machine(),
        "cases": {},
        "ratios": {},
        "ratios_alternating": {},
        "mission_steps": MISSION_STEPS,
    }
    console = Console(stderr=True)
    with console.status("benchmark") as status:
        for case in cases():
            status.update(f"{case.name}: preparing")
            with acados_peers(case.problem, acados, console.print) as peers:
                records = measure(
                    case,
                    {**all_solvers(case), **peers},
                    repetitions=2 if quick else 6,
                    cold=cold,
                    peers_cold=min(cold, peers_cold),
                    seed=seed,
                    progress=status.update,
                )
            for name in [name for name, peer in peers.items() if peer.lost]:
                del records[name]
            figures = summary(records)
            results["cases"][case.name] = figures
            results["ratios"][case.name] = _ratios(figures, "transient_median_us")
            results["ratios_alternating"][case.name] = _ratios(figures, "alternating_median_us")
        status.update("missions")
        results["missions_per_second"] = missions_per_second(paper_case(10), MISSION_STEPS)
        if not quick:
            results["horizons"] = HORIZONS
            results["horizon_median_us"] = horizon_sweep(HORIZONS, paper_case, status.update)
    results["duration_s"] = time.perf_counter() - begin
    return results


def _ratios(figures: dict[str, dict[str, Any]], key: str) -> dict[str, float]:
    """Figure of every other solver over ours."""
    return {name: row[key] / figures[OURS][key] for name, row in figures.items() if name != OURS}
