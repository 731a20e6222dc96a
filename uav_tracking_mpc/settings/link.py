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

"""The link to an autopilot, as parameters."""

from __future__ import annotations

from dataclasses import dataclass

from uav_tracking_mpc.parameters.specification import ParameterError, parameter
from uav_tracking_mpc.settings.frame_parameters import FrameParameters


@dataclass(frozen=True)
class LinkParameters(FrameParameters):
    """Which autopilot flies, where it is, and what may be asked of it."""

    link: str = parameter(
        "ardupilot", "Which autopilot.", extension="uav_tracking_mpc.links", fixed=True
    )
    connection: str = parameter(
        "",
        "Where it is: udpin:HOST:PORT, udpout:HOST:PORT, tcp:HOST:PORT, tcpin:HOST:PORT or "
        "serial:DEVICE:BAUD; empty for udpin:127.0.0.1:14550.",
        fixed=True,
    )
    engage: bool = parameter(
        False,
        "Take command as soon as there is something to fly and nothing speaks against it.",
        fixed=True,
    )
    engage_on_mode: bool = parameter(
        False,
        "A pilot who switches to the mode of external commands hands over command.",
        fixed=True,
    )
    origin: tuple[float, ...] = parameter(
        (),
        "Latitude [deg], longitude [deg] and altitude above sea level [m] of the origin of map; "
        "empty for the autopilot's home.",
        lower=-1e4,
        upper=1e5,
        multiple=3,
        fixed=True,
    )
    telemetry_rate: float = parameter(
        50.0, "How often the state is asked for.", "Hz", 5.0, 400.0, fixed=True
    )
    system: int = parameter(
        0,
        "MAVLink system of the autopilot; 0 for the first that is heard, but target_system.",
        lower=0,
        upper=255,
        fixed=True,
    )
    target_system: int = parameter(
        0,
        "MAVLink system of a vehicle to circle, which sends GLOBAL_POSITION_INT or FOLLOW_TARGET; "
        "0 for the target of target/position.",
        lower=0,
        upper=255,
        fixed=True,
    )
    signing_key: str = parameter(
        "", "File with the 32 bytes of a key to sign messages with; empty to sign none.", fixed=True
    )

    def __post_init__(self) -> None:
        """Check that the origin is one place on earth."""
        super().__post_init__()
        if self.origin and not (len(self.origin) == 3 and self._on_earth(*self.origin)):
            raise ParameterError(
                f"parameter 'origin' is {list(self.origin)}, must be latitude within 90 deg, "
                "longitude within 360 deg and altitude in m, or empty"
            )

    @staticmethod
    def _on_earth(latitude: float, longitude: float, _: float) -> bool:
        return abs(latitude) <= 90.0 and abs(longitude) <= 360.0
