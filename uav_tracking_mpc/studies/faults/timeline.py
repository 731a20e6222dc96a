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

"""A campaign in one figure: how far from the orbit, what was injected, what came of it."""

from __future__ import annotations

from uav_tracking_mpc.report.figure_style import BLUE, GREEN, GREY, VERMILLION, drawing
from uav_tracking_mpc.report.figure_style import png as as_png
from uav_tracking_mpc.studies.faults.fault_findings import Campaign


def timeline(campaign: Campaign, tolerance: float, limit: float) -> bytes:
    """The figure as PNG.

    Args:
        campaign: What to draw.
        tolerance: Range error within which the aircraft counts as on its orbit [m].
        limit: Time allowed for a recovery [s].
    """
    families = list(dict.fromkeys(campaign.families.values()))
    with drawing(9.0, 6.5) as figure:
        upper, middle, lower = figure.subplots(
            3, 1, sharex=True, gridspec_kw={"height_ratios": (2, 2.4, 1.6)}
        )
        times = [time / 60.0 for time, _ in campaign.range_errors]
        upper.plot(times, [error for _, error in campaign.range_errors], color=BLUE, linewidth=0.8)
        upper.axhspan(-tolerance, tolerance, color=GREEN, alpha=0.15, linewidth=0)
        upper.set_ylabel("r - r_d [m]")
        upper.set_title(
            f"{campaign.config}, seed {campaign.seed}: true range error; "
            f"the band is {tolerance:g} m wide either way"
        )
        for case in campaign.cases:
            color = VERMILLION if case.violations else GREY
            width = max(case.end - case.begin, 0.2) / 60.0
            for kind in case.kinds:
                row = families.index(campaign.families[kind])
                middle.broken_barh([(case.begin / 60.0, width)], (row - 0.4, 0.8), color=color)
            height = limit if case.recovery is None else case.recovery
            lower.plot(case.begin / 60.0, height, "o", markersize=3, color=color)
        middle.set_yticks(range(len(families)), [name.replace("_", " ") for name in families])
        middle.invert_yaxis()
        middle.set_title("cases by what they strike; with violations in red")
        lower.axhline(limit, color=VERMILLION, linewidth=0.8, linestyle="--")
        lower.set_ylim(bottom=0.0)
        lower.set_ylabel("recovery [s]")
        lower.set_title(f"simulated time from the last fault to the orbit; allowed {limit:g} s")
        lower.set_xlabel("wall time [min]")
        figure.tight_layout()
        return as_png(figure)
