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

"""Which sensors are used, and why one is not: told once at each change."""

from __future__ import annotations

from collections.abc import Iterator

SENSORS = AIRSPEED, HEADING, POSITION, VELOCITY = (
    "airspeed",
    "heading",
    "position",
    "ground velocity",
)
STATES = USED, SILENT, STUCK, JUMPED, OFF = "used", "silent", "stuck", "jumped", "off"
CODE = {state: float(number) for number, state in enumerate(STATES)}  # where a number is needed
SAID = {
    USED: "agrees with the others: it is used again",
    SILENT: "is not measured",
    STUCK: "is stuck",
    JUMPED: "has jumped",
    OFF: "is off",
}
# Nothing but the ground velocity tells of positions: one that stays elsewhere is believed at last.
STAYED = "agrees with the others, or has stayed where it is: it is used again"
INSTEAD = {
    AIRSPEED: "ground velocity and wind stand in for it",
    HEADING: "ground velocity and wind stand in for it",
    POSITION: "the ground velocity carries the last one on",
    VELOCITY: "air velocity and wind stand in for it",
}
WITHOUT_AIRSPEED = INSTEAD | {
    HEADING: "the gyros carry the one before on",
    VELOCITY: "positions alone tell how the aircraft moves",
}


class SensorHealth:
    """The state of each sensor.

    Attributes:
        states: By the sensor's name: :data:`USED`, or why it is left out, in a word.
    """

    def __init__(self) -> None:
        self.states = dict.fromkeys(INSTEAD, USED)
        self._told = dict(self.states)

    def news(self) -> Iterator[str]:
        """What has become of the sensors since it was asked last, in words."""
        alone = self.states[AIRSPEED] != USED
        for sensor, state in self.states.items():
            if state != self._told[sensor]:
                self._told[sensor] = state
                words = (WITHOUT_AIRSPEED if alone else INSTEAD)[sensor]
                instead = "" if state == USED else f": {words}"
                said = STAYED if (sensor, state) == (POSITION, USED) else SAID[state]
                yield f"{sensor} {said}{instead}"

    def values(self) -> dict[str, str]:
        """The states as diagnostics name them."""
        return {f"{sensor} sensor": state for sensor, state in self.states.items()}
