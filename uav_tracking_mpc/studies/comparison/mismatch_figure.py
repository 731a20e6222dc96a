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

"""A picture of all mismatches: range and bank rate RMS of every law, and what is asked."""

from __future__ import annotations

import math
from collections.abc import Sequence

from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.markers import CARETLEFT

from uav_tracking_mpc.report.figure_style import BLACK, LIGHT_GREY, colours, drawing
from uav_tracking_mpc.settings.tracking import PREDICTIVE
from uav_tracking_mpc.studies.comparison.mismatch_targets import asked_of, resolved
from uav_tracking_mpc.studies.comparison.results import Scenario

FINEST = (1e-3, 0.1)  # m and deg/s, the least that is drawn
MARKERS = ("o", "s", "D", "^", "v", "P", "X")


def mismatch_figure(mismatches: Sequence[Scenario]) -> Figure:
    """A row for each mismatch, a mark for each law, a bar where the predictive controller is asked.

    Args:
        mismatches: What was flown.
    """
    height = 1.1 + 0.27 * max(len(mismatches), 2)  # [inch]
    laws = list(dict.fromkeys(law for mismatch in mismatches for law in mismatch.measures))
    colour = colours(laws)
    marker = {law: MARKERS[index % len(MARKERS)] for index, law in enumerate(laws)}
    # The predictive controller's marks lie above the others.
    order = {law: 4 if law == PREDICTIVE else 3 for law in laws}
    with drawing(9.5, height) as figure:
        panels = figure.subplots(1, 2, sharey=True)
        for index, mismatch in enumerate(mismatches):
            for law, flight in mismatch.measures.items():
                for axes, value, finest in zip(
                    panels, (flight.range_rms_m, flight.bank_rate_rms_dps), FINEST, strict=True
                ):
                    axes.plot(
                        max(value, finest), index, ls="", color=colour[law], ms=5.0,
                        marker=marker[law] if value >= finest else CARETLEFT,
                        mec="white", mew=0.4, zorder=order[law],
                    )  # fmt: skip
            asked = asked_of(mismatch.configuration, mismatch.name)
            if asked is None or PREDICTIVE not in mismatch.measures:
                continue
            bounds = resolved(asked, mismatch.measures)
            for axes, bound in zip(panels, (bounds.range_rms, bounds.bank_rate_rms), strict=True):
                if math.isfinite(bound):
                    axes.plot([bound] * 2, [index - 0.36, index + 0.36], color=BLACK, lw=1.6)
        for axes, title, finest in zip(
            panels, ("range RMS [m]", "bank rate RMS [deg/s]"), FINEST, strict=True
        ):
            axes.set_xscale("log")
            axes.set_xlim(left=0.8 * finest)
            axes.set_title(title)
            axes.grid(axis="y", color=LIGHT_GREY, lw=0.5)
        panels[0].set_yticks(range(len(mismatches)), [mismatch.name for mismatch in mismatches])
        panels[0].set_ylim(len(mismatches) - 0.5, -0.5)
        handles = [
            Line2D([], [], color=colour[law], marker=marker[law], ls="", label=law) for law in laws
        ]
        less = f"below {FINEST[0]:g} m or {FINEST[1]:g} deg/s"
        handles.append(Line2D([], [], color=BLACK, marker=CARETLEFT, ls="", label=less))
        handles.append(
            Line2D([], [], color=BLACK, marker="|", ls="", ms=9, mew=1.6, label="asked of nmpc")
        )
        figure.subplots_adjust(
            left=0.15, right=0.985, bottom=0.4 / height, top=1.0 - 0.65 / height, wspace=0.06
        )
        figure.legend(handles=handles, loc="upper center", ncols=len(handles))
    return figure
