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

"""Hours of flight without faults: is the orbit held all the while, does any process grow."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

from rich.console import Console

from uav_tracking_mpc.launch.supervisor import LaunchError
from uav_tracking_mpc.report.atomic_write import json_text
from uav_tracking_mpc.settings.configuration import Configuration
from uav_tracking_mpc.studies.faults.fault_campaign import STALL_LIMIT
from uav_tracking_mpc.studies.faults.node_campaign import NodeCampaign
from uav_tracking_mpc.studies.faults.resources import Growth, Usage
from uav_tracking_mpc.studies.study import Study

SPEED = 20.0  # -, simulated over wall time, as far as the machine keeps up
SETTLING = 180.0  # s of simulated time to fly onto the orbit
REPORT_PERIOD = 20.0  # s of wall time


def soak(
    configuration: Configuration,
    hours: float,
    output: Path,
    console: Console,
    domain: int | None = None,
) -> Study:
    """Fly for hours of simulated time, at the speed of the mission.

    Args:
        configuration: What to fly.
        hours: Simulated [h].
        output: Existing folder for the nodes' output.
        console: Where progress goes.
        domain: ROS domain; None takes one that no other launch uses.

    Raises:
        LaunchError: The aircraft did not reach its orbit, or time stood still.
        KeyboardInterrupt: A signal came.
    """
    campaign = NodeCampaign(configuration, {}, output, console)
    recovery = campaign.recovery
    with campaign.flight(domain):
        observer = campaign.observer
        begin, flown = time.monotonic(), recovery.flown
        settled, told = False, 0.0
        for stalled in campaign.watch():
            wall = time.monotonic() - begin
            if not settled and recovery.flown > SETTLING:
                settled, observer.longest_gap = True, 0.0
                recovery.begin()
            if recovery.flown >= 3600.0 * hours:
                break
            if stalled:
                raise LaunchError(f"simulated time stood still for {STALL_LIMIT:g} s")
            if wall - told > REPORT_PERIOD:
                told = wall
                console.print(
                    f"{recovery.flown / 3600.0:6.3f} h simulated, "
                    f"{(recovery.flown - flown) / wall:5.1f} times real time, "
                    f"r - r_d {recovery.range_error:+7.3f} m, at most {recovery.worst[0]:.3f} m, "
                    f"{observer.commands} commands",
                    highlight=False,
                )
    worst, when = recovery.worst
    nodes = {name: _told(growth) for name, growth in campaign.latest().items()}
    broken = {violation.invariant: violation.detail for violation in reversed(campaign.violations)}
    violations = (worst > campaign.tolerance) + len(broken)
    violations += sum(bool(node["complaint"]) for node in nodes.values())
    content = {
        "config": configuration.name,
        "simulated_hours": recovery.flown / 3600.0,
        "wall_minutes": wall / 60.0,
        "speed": (recovery.flown - flown) / wall,
        "control_rate_hz": observer.commands / recovery.flown,
        "control_rate_wanted_hz": configuration.controller.control_rate,
        "longest_gap_s": observer.longest_gap,
        "max_range_error_m": worst,
        "max_range_error_at_s": when,
        "rss_growth_percent": max(node["rss_growth_percent"] for node in nodes.values()),
        "nodes": nodes,
        "broken": broken,
        "violations": violations,
    }
    return Study("soak", content, [json_text(content)], good=not violations)


def _told(growth: Growth) -> dict[str, Any]:
    """How a process grew after its warm-up."""
    half, used = growth.second_half(), [used for _, used in growth.samples] or [Usage(0, 0, 0)]
    return {
        "rss_mb": used[-1].rss / 1e6,
        "rss_growth_percent": growth.rss_percent(),
        "rss_growth_second_half_percent": half.rss_percent(),
        "handles": [used[0].handles, used[-1].handles],
        "threads": [used[0].threads, used[-1].threads],
        "complaint": half.complaint(),
    }
