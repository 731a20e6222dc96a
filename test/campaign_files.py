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

"""Campaigns of short flights, for tests."""

from __future__ import annotations

import yaml

from uav_tracking_mpc.studies.campaign.campaign_file import load_campaign

SHORT = {
    "flights": 6,
    "seed": 3,
    "laws": ["l1"],
    "settled_after": 4.0,
    "draw": {
        "mission.duration": 6.0,
        "start.distance": {"uniform": [290.0, 320.0]},
        "wind.speed": {"uniform": [0.0, 8.0]},
        "wind.direction_deg": {"uniform": [-180.0, 180.0]},
    },
    "errors": {
        "lag": {"told.response": {"uniform": [0.0, 3.0]}},
        "sensors": {"uav_simulator.velocity_noise": {"uniform": [0.0, 0.3]}},
        "driving": {
            "target_publisher.motion": {"choice": ["circle", "line"]},
            "target_publisher.speed": 4.0,
        },
    },
    "groups": {
        "single": {"share": 0.5, "errors": "one"},
        "together": {"share": 0.5, "errors": "all", "range": 0.5},
    },
    "failure": {"orbit_lost": {"beyond": 40.0, "settled_for": 2.0}, "never_settled": {}},
}


def written(folder, name="short", **changes):
    """File of that campaign, with parts of it replaced; None leaves one out."""
    content = {key: value for key, value in {**SHORT, **changes}.items() if value is not None}
    path = folder / f"{name}.yaml"
    path.write_text(yaml.safe_dump(content, sort_keys=False))
    return path


def short_campaign(folder, **changes):
    return load_campaign(str(written(folder, **changes)))
