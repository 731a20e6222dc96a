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

"""PX4 in OFFBOARD: it is told attitude and thrust, all three inputs are ours.

=========================  ==================================================================
SET_ATTITUDE_TARGET        bank, from the turn rate; pitch and thrust, from the energy law
DO_SET_MODE                enters OFFBOARD; Hold, when command is given back
CURRENT_MODE, HEARTBEAT    who flies; the former ten times a second where PX4 has it
=========================  ==================================================================

Read in PX4's sources: the set-point counts only with MAV_FWDEXTSP, as proof of life even outside of
OFFBOARD, and carries no thrust where it says that thrust is to be ignored
(src/modules/mavlink/mavlink_receiver.cpp, ``handle_message_set_attitude_target``). The last one is
flown for COM_OF_LOSS_T, then comes what COM_OBL_RC_ACT says (src/modules/commander,
``offboardCheck.cpp``; ``failsafe.cpp``, ``fromOffboardLossActParam``). That failsafe ends by itself
when set-points come again. So none are sent after it, unless it was the link that was dead: then
inert ones are, which hold bank and height, until OFFBOARD is there again. A pilot who has changed
the mode is not overridden by them.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.dynamics.atmosphere import true_over_equivalent
from uav_tracking_mpc.dynamics.flown_orbit import FlownOrbit
from uav_tracking_mpc.dynamics.frames import bank_from_turn_rate, quaternion_from_euler
from uav_tracking_mpc.estimation.measurement import Measurement
from uav_tracking_mpc.links import Inspection
from uav_tracking_mpc.links.mavlink.dialect import CURRENT_MODE, mavlink
from uav_tracking_mpc.links.mavlink.energy_law import EnergyLaw, FlownPath
from uav_tracking_mpc.links.mavlink.engagement import State
from uav_tracking_mpc.links.mavlink.findings import firmware, inspection, state_refusal
from uav_tracking_mpc.links.mavlink.mavlink_link import MavlinkLink
from uav_tracking_mpc.links.mavlink.px4_envelope import NAMES, Px4Envelope
from uav_tracking_mpc.links.mavlink.telemetry import Attitude

# Main and sub mode of custom_mode: src/modules/commander/px4_custom_mode.h
MODES = {
    (1, 0): "MANUAL", (2, 0): "ALTITUDE", (3, 0): "POSITION", (3, 2): "POSITION", (4, 1): "READY",
    (4, 2): "TAKEOFF", (4, 3): "HOLD", (4, 4): "MISSION", (4, 5): "RETURN", (4, 6): "LAND",
    (4, 8): "FOLLOW_TARGET", (4, 9): "PRECLAND", (4, 10): "VTOL_TAKEOFF", (5, 0): "ACRO",
    (6, 0): "OFFBOARD", (7, 0): "STABILIZED", (10, 0): "TERMINATION", (11, 0): "ALTITUDE_CRUISE",
}  # fmt: skip
OFFBOARD, HOLD = (6, 0), (4, 3)
HANDED_OVER = ("HOLD", "MISSION", "POSITION", "OFFBOARD")  # modes command may be taken from
NO_RATES = 0b111  # type_mask: rates are ignored; attitude and thrust are not
CUSTOM_MODE = 1.0  # param1 of DO_SET_MODE
INERT_TIME = 1.2  # s of inert set-points before OFFBOARD is asked for; PX4 wants more than 1 s
SAME_RATIO = 1e-3  # of true and equivalent airspeed: 20 m of altitude
FENCE_PERIOD = 0.5  # s between looks at the fence
STALE = 1.0  # s that the newest measurement may be old


def main_and_sub(custom_mode: int) -> tuple[int, int]:
    """Main and sub mode.

    Args:
        custom_mode: Of HEARTBEAT or CURRENT_MODE.
    """
    return custom_mode >> 16 & 0xFF, custom_mode >> 24 & 0xFF


class Px4Link(MavlinkLink):
    """PX4 with a fixed wing, which is asked for its mode OFFBOARD."""

    name = "px4"
    title = "PX4"
    when_silent = (
        "holds its last attitude and thrust for COM_OF_LOSS_T, then goes to Hold or Return as "
        "COM_OBL_RC_ACT says"
    )
    autopilot = mavlink.MAV_AUTOPILOT_PX4
    asked_parameters = NAMES
    by_bits = True
    slow_messages = (mavlink.MAVLINK_MSG_ID_WIND_COV, mavlink.MAVLINK_MSG_ID_ESTIMATOR_STATUS)
    quick_messages = (CURRENT_MODE,)
    stream_period = 0.02

    def _forget(self) -> None:
        super()._forget()
        self._law: EnergyLaw | None = None
        self._known: Px4Envelope | None = None
        self._known_at = math.nan
        self._bank, self._banked_at = 0.0, -math.inf
        self._inert_since: float | None = None

    def mode_name(self, custom_mode: int) -> str:
        """See :meth:`MavlinkLink.mode_name`."""
        main, sub = main_and_sub(custom_mode)
        return MODES.get((main, sub), f"number {main}.{sub}")

    def takes_commands(self, custom_mode: int) -> bool:
        """See :meth:`MavlinkLink.takes_commands`."""
        return main_and_sub(custom_mode)[0] == OFFBOARD[0]

    def _envelope(self) -> Px4Envelope:
        ratio = self._ratio()
        if self._known is None or abs(ratio - self._known_at) > SAME_RATIO:
            self._known, self._known_at = Px4Envelope(self.vehicle, ratio), ratio
        return self._known

    def _ratio(self) -> float:
        return true_over_equivalent(self.heard.telemetry.altitude or 0.0)

    def describe(self) -> Inspection:
        """See :meth:`MavlinkLink.describe`."""
        heard, envelope = self.heard, self._envelope()
        mode = self.mode_name(heard.heartbeat.custom_mode)
        refusals = [state_refusal(heard, mode, HANDED_OVER), *envelope.refusals()]
        told = {"firmware": f"{self.title} {firmware(heard.version)}", "mode": mode}
        warnings = envelope.warnings()
        return inspection(heard, told, self.vehicle, envelope, warnings, refusals)

    def refusal(self, orbit: FlownOrbit) -> str:
        """See :meth:`MavlinkLink.refusal`: what its fence says."""
        fence = self._envelope().fence()
        return "" if fence is None else fence.refusal(orbit, self.heard.telemetry)

    def ask_for_command(self, now: float) -> None:
        """See :meth:`MavlinkLink.ask_for_command`: once set-points have come for long enough."""
        if self._inert_since is not None and now - self._inert_since >= INERT_TIME:
            self._set_mode(now, OFFBOARD, "the mode OFFBOARD")

    def _set_mode(self, now: float, mode: tuple[int, int], words: str) -> None:
        command = mavlink.MAV_CMD_DO_SET_MODE
        self.heard.requests.ask(now, command, words, CUSTOM_MODE, *map(float, mode))

    def begin(self, now: float) -> None:
        """See :meth:`MavlinkLink.begin`: the law goes on from what is flown."""
        self._inert_since = None
        telemetry = self.heard.telemetry
        attitude, measured = telemetry.attitude, telemetry.newest
        self._law = EnergyLaw(self._envelope().energy_limits())
        if attitude is not None and measured is not None and measured.airspeed is not None:
            flown = self._flown(attitude, measured, measured.airspeed, now)
            self._law.begin(flown, attitude.pitch, telemetry.throttle)
            self._bank, self._banked_at = attitude.roll, now

    def accompany(self, now: float) -> None:
        """See :meth:`MavlinkLink.accompany`: command is given back where the orbit is refused."""
        if self.orbit is None or not self.heard.is_due("fence", now, FENCE_PERIOD):
            return
        if refusal := self.refusal(self.orbit):
            self.engagement.give_up(refusal)
            self.let_go(now)

    def let_go(self, now: float) -> None:
        """See :meth:`MavlinkLink.let_go`."""
        self._set_mode(now, HOLD, "the mode Hold")

    def fly(self, inputs: NDArray[np.float64], measured: Measurement, now: float) -> None:
        """See :meth:`MavlinkLink.fly`."""
        attitude, airspeed = self.heard.telemetry.attitude, measured.airspeed
        if attitude is None or airspeed is None or now - measured.stamp > STALE:
            return  # without these nothing is flown blindly: PX4 does as when we are silent
        if self._law is None:
            self.begin(now)
        assert self._law is not None
        turn_rate, path_rate, gain = np.asarray(inputs, dtype=float).tolist()
        envelope = self._envelope()
        limit, reach = envelope.bank_max(airspeed) or 0.0, envelope.roll_slew
        coordinated = turn_rate - self.heard.telemetry.direction.surplus
        wanted = _clip(bank_from_turn_rate(coordinated, airspeed), limit)
        change = _clip(wanted - self._bank, reach * (now - self._banked_at))
        self._bank, self._banked_at = _clip(self._bank + change, limit), now
        flown = self._flown(attitude, measured, airspeed, now)
        pitch, thrust = self._law.step(path_rate, gain, flown)
        self._send(self._bank, pitch, thrust, attitude)

    def _hold(self, now: float) -> None:
        """Send an inert set-point: bank, height and thrust as they are."""
        telemetry = self.heard.telemetry
        attitude, measured = telemetry.attitude, telemetry.newest
        if attitude is None or measured is None or now - measured.stamp > STALE:
            self._inert_since = None
            return
        self._inert_since = self._inert_since or now
        self._sent_at = now
        envelope = self._envelope()
        limits = envelope.energy_limits()
        limit = envelope.bank_max(measured.airspeed or 0.0) or 0.0
        pitch = attitude.pitch - measured.path_angle
        thrust = limits.trim if telemetry.throttle is None else telemetry.throttle
        self._send(
            _clip(attitude.roll, limit),
            min(max(pitch, limits.pitch_min), limits.pitch_max),
            min(max(thrust, limits.thrust_min), limits.thrust_max),
            attitude,
        )

    def _send(self, bank: float, pitch: float, thrust: float, attitude: Attitude) -> None:
        self.heard.connection.send(
            mavlink.MAVLink_set_attitude_target_message(
                self.heard.connection.boot_time, self.heard.system, 1, NO_RATES,
                quaternion_from_euler(bank, pitch, attitude.yaw), 0.0, 0.0, 0.0, thrust,
            )
        )  # fmt: skip

    def _flown(
        self, attitude: Attitude, measured: Measurement, airspeed: float, now: float
    ) -> FlownPath:
        return FlownPath(now, measured.path_angle, airspeed, attitude.roll, self._ratio())

    @property
    def _streams(self) -> bool:
        # A pilot who may hand over finds set-points that stream, but not after a failsafe.
        if self.engagement.state is not State.IDLE:
            return True
        heartbeat = self.heard.heartbeat
        waits = (
            self.parameters.engage_on_mode
            and heartbeat is not None
            and self.heard.armed
            and not self.takes_commands(heartbeat.custom_mode)
            and heartbeat.system_status != mavlink.MAV_STATE_CRITICAL
        )
        if not waits:
            self._inert_since = None
        return bool(waits)

    def _fly(self, now: float) -> None:
        if self.engagement.commanding:
            super()._fly(now)
        else:
            self._hold(now)

    def _see(self, message: Any, arrival: float) -> None:
        """See :class:`MavlinkLink`: CURRENT_MODE ends our commands, but begins none."""
        super()._see(message, arrival)
        if message.get_type() != "CURRENT_MODE" or self.takes_commands(message.custom_mode):
            return
        if self.engagement.state in (State.ENGAGED, State.SUSPENDED):
            # Where a failsafe flies, OFFBOARD is still what the pilot wants.
            failsafe = self.takes_commands(message.intended_custom_mode)
            mode = self.mode_name(message.custom_mode)
            self.engagement.see_mode(arrival, False, mode, self.heard.armed, failsafe)


def _clip(value: float, limit: float) -> float:
    return min(max(value, -limit), limit)
