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

"""How an autopilot speaks, as far as its dialects differ on the wire."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from uav_tracking_mpc.autopilot.numbers import Result


class WireTraits(NamedTuple):
    """What one autopilot does and another does not.

    Attributes:
        maker: MAV_AUTOPILOT.
        version: Of the firmware that is imitated: major, minor, patch.
        capabilities: MAV_PROTOCOL_CAPABILITY.
        stream_rates: How often each message is sent that nobody asked for, in [Hz].
        mode_messages: Messages that are sent at once when the mode has changed.
        lacking: Messages that only the others have.
        sync_period: How often it asks for the time by TIMESYNC, in [s].
        unknown_message: Answer to a request for a message that there is none of.
        hears_all: Whether commands to system 0 are carried out.
        bytewise: Whether integers travel as the bytes of a float.
        set_mode_acknowledged: The command that the answer to SET_MODE names.
    """

    maker: int
    version: tuple[int, int, int]
    capabilities: int
    stream_rates: Mapping[str, float]
    mode_messages: tuple[str, ...]
    lacking: tuple[str, ...]
    sync_period: float
    unknown_message: Result
    hears_all: bool
    bytewise: bool
    set_mode_acknowledged: int
