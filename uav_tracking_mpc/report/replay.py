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

"""A flight as a moving scene that a page can hold: what draws it is above the report."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Replay:
    """A scene that plays by itself in a browser.

    Attributes:
        html: A whole page that asks for nothing from elsewhere.
        pace: Time of the flight over time of the replay [-].
        frames: Pictures of the flight in it.
    """

    html: str
    pace: float
    frames: int
