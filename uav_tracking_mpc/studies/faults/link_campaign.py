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

"""Faults on the wire to a simulated autopilot, one after the other, and what came of each."""

from __future__ import annotations

import random
import time
from collections.abc import Iterable, Iterator, Sequence
from typing import Any

from rich.console import Console

from uav_tracking_mpc.autopilot.simulated_autopilot import SteppedAutopilot
from uav_tracking_mpc.autopilot.wire_faults import WIRE_FAULTS
from uav_tracking_mpc.links.mavlink.connection import Connection
from uav_tracking_mpc.links.mavlink.dialect import mavlink
from uav_tracking_mpc.settings.configuration import Configuration
from uav_tracking_mpc.studies.faults.fault_campaign import FaultCampaign, Injection
from uav_tracking_mpc.studies.faults.fault_findings import Campaign, CaseFindings
from uav_tracking_mpc.studies.faults.kinds import Fault
from uav_tracking_mpc.studies.faults.link_flight import LinkFlight
from uav_tracking_mpc.studies.faults.schedule import Case

SETTLING_LIMIT = 90.0  # s to the orbit, from wherever the autopilot was left
LOITERS = ("LOITER", "RTL", "HOLD", "RETURN", "GUIDED", "OFFBOARD")  # it circles by itself
HAND_FLOWN = ("FBWA", "MANUAL", "RTL", "LOITER", "STABILIZED", "HOLD")
SAMPLE_PERIOD = 1.0  # s between errors that are kept for the figure
BAD_FRAMES = 100_000  # frames
SENDER = 3  # code: MAVLink system of the good frames


class WireFault(Fault):
    """A fault of the wire.

    Args:
        name: One of :data:`~uav_tracking_mpc.autopilot.wire_faults.WIRE_FAULTS`.
    """

    family = "wire"

    def __init__(self, name: str) -> None:
        self.name, self.duration = name, WIRE_FAULTS[name].duration

    def begin(self, flight: Any, seconds: float, seed: int) -> None:
        """See :meth:`Fault.begin`."""
        self._fault = flight.autopilot.begin_fault(self.name, seed)

    def end(self, flight: Any) -> None:
        """See :meth:`Fault.end`."""
        flight.autopilot.end_fault(self._fault)


class TakeOver(Fault):
    """The pilot switches to another mode; nothing may be commanded after the message that says so.

    It is watched for as long as it lasts.
    """

    name = "take_over"
    family = "pilot"
    duration = (3.0, 3.0)

    def begin(self, flight: Any, seconds: float, seed: int) -> None:
        """See :meth:`Fault.begin`."""
        self._told: list[int] = []
        self._before = flight.link.heard.on_message

        def listen(message: Any, arrival: float) -> None:
            self._before(message, arrival)
            tells = message.get_type() in ("HEARTBEAT", "CURRENT_MODE")
            if tells and not flight.link.takes_commands(message.custom_mode):
                self._told.append(flight.sent.set_points)

        flight.link.heard.on_message = listen
        modes = [mode for mode in HAND_FLOWN if mode in flight.autopilot.core.modes]
        self._mode = random.Random(seed).choice(modes)
        flight.autopilot.pilot_mode(self._mode)

    def end(self, flight: Any) -> None:
        """See :meth:`Fault.end`."""
        flight.link.heard.on_message = self._before
        late = flight.sent.set_points - (self._told[0] if self._told else 0)
        if late or flight.link.engaged:
            flight.sent.blame("take-over", f"{late} set-points after mode {self._mode} was told")


class CompanionDead(Fault):
    """The companion is dead for a while, then comes back as if nothing had been."""

    name = "companion_dead"
    family = "companion"
    duration = (10.0, 40.0)

    def begin(self, flight: Any, seconds: float, seed: int) -> None:
        """See :meth:`Fault.begin`."""
        flight.silent = True

    def end(self, flight: Any) -> None:
        """See :meth:`Fault.end`."""
        flight.silent = False


LINK_FAULTS: dict[str, Fault] = {
    fault.label: fault for fault in (*map(WireFault, WIRE_FAULTS), TakeOver(), CompanionDead())
}


class LinkCampaign(FaultCampaign):
    """A campaign over a link, in simulated time.

    Args:
        dialect: Name of the link and of the simulated autopilot.
        configuration: What to fly.
        console: Where progress goes.

    Raises:
        LinkError: The autopilot refuses to be flown.
    """

    tolerance = 1.0
    flight: LinkFlight

    def __init__(self, dialect: str, configuration: Configuration, console: Console) -> None:
        super().__init__(configuration, LINK_FAULTS, console)
        self._dialect, self._before = dialect, 0.0
        self.flight = LinkFlight(dialect, configuration)

    def now(self) -> float:
        """See :meth:`FaultCampaign.now`: of simulated time."""
        return self._before + self.flight.time

    @property
    def flown(self) -> float:
        """See :attr:`FaultCampaign.flown`."""
        return self.flight.time

    @property
    def range_error(self) -> float:
        """See :attr:`FaultCampaign.range_error`."""
        return self.flight.errors[0]

    def fly(self, cases: Iterable[Case], *, seed: int) -> Campaign:
        """Fly cases until there are no more, or the user interrupts.

        Args:
            cases: In this order.
            seed: Of the cases, for the record.

        Raises:
            KeyboardInterrupt: Before the first case was flown; later the findings are returned.
        """
        interrupted = self.fly_cases(cases)
        found = self.found
        outcomes = {
            "orbit": sum(case.recovery is not None for case in found),
            "loiter": sum(case.loiters for case in found),
            "lost": sum(case.lost for case in found),
        }
        connection = SteppedAutopilot(self._dialect, self.configuration).connection("", 191, "")
        return self.campaign(
            seed,
            dialect=self._dialect,
            interrupted=interrupted,
            outcomes=outcomes,
            frames=read_bad_frames(connection, BAD_FRAMES, seed),
        )

    def fly_case(self, case: Case) -> CaseFindings:
        """See :meth:`FaultCampaign.fly_case`: on the orbit first; nothing may end a flight.

        Args:
            case: To fly.
        """
        struck, findings = self.flight, CaseFindings(case.index, case.kinds, self.now())
        try:
            self._engage()
            findings = super().fly_case(case)
        except Exception as error:
            struck.sent.blame("exception", f"{type(error).__name__}: {error}")
            self._before = self.now()
            self.flight = LinkFlight(self._dialect, self.configuration)
        findings.violations |= struck.sent.take()
        return findings

    def watch(self, findings: CaseFindings, injections: Sequence[Injection] = ()) -> Iterator[bool]:
        """See :meth:`FaultCampaign.watch`: simulated time never stands still."""
        while True:
            self._step()
            yield False

    def _step(self) -> None:
        flight = self.flight
        flight.step()
        self.recovery.state(flight.time, *flight.errors, flight.link.engaged)
        if not self.range_errors or self.now() - self.range_errors[-1][0] > SAMPLE_PERIOD:
            self.range_errors.append((self.now(), self.range_error))

    def _engage(self) -> None:
        """Hand command over as a pilot does, and wait for the orbit."""
        flight, asked = self.flight, -1.0
        self.recovery.begin(begin := flight.time)
        if not flight.link.engaged:
            flight.autopilot.pilot_mode(flight.autopilot.core.loiter_mode)
        while self.recovery.done(flight.time) is None:
            self._step()
            if not flight.link.engaged and flight.time - asked > 1.0:
                asked = flight.time
                flight.link.engage()
            if flight.time - begin > SETTLING_LIMIT:
                raise RuntimeError(f"not on the orbit {SETTLING_LIMIT:g} s after it was engaged")

    def excused(self, findings: CaseFindings) -> bool:
        """See :meth:`FaultCampaign.excused`: the autopilot circles and waits to be engaged.

        Args:
            findings: Of the case that it does not recover from.
        """
        by_itself = self.flight.autopilot.core.mode in LOITERS and not self.flight.link.engaged
        return by_itself or TakeOver.name in findings.kinds


def changed(random_: random.Random, good: bytes) -> bytes:
    """A frame with some bytes changed, cut off, missing or put in between; never the same.

    Args:
        random_: Where all that is random comes from.
        good: The frame.
    """
    while (bad := _changed(random_, good)) == good:
        pass
    return bad


def _changed(random_: random.Random, good: bytes) -> bytes:
    frame = bytearray(good)
    kind = random_.randrange(5)
    if kind == 0:
        for _ in range(random_.randrange(1, 6)):
            frame[random_.randrange(len(frame))] ^= random_.randrange(1, 256)
    elif kind == 1:
        del frame[random_.randrange(1, len(frame)) :]
    elif kind == 2:
        place = random_.randrange(len(frame))
        frame[place:place] = random_.randbytes(random_.randrange(1, 30))
    elif kind == 3:
        frame = bytearray(random_.randbytes(random_.randrange(1, 300)))
    else:
        start = random_.randrange(len(frame))
        del frame[start : start + random_.randrange(1, 8)]
    return bytes(frame)


def read_bad_frames(connection: Connection, count: int, seed: int) -> dict[str, float]:
    """Bad frames, each followed by a good one, as a connection reads them.

    Args:
        connection: Of datagrams; nothing is sent.
        count: Of bad frames.
        seed: Of everything random.

    Returns:
        ``bad``: how many; ``taken``: of them for messages, the checksum of 16 bits lets one in
        65 536 pass; ``good_lost``: good ones that were not read; ``bad_us`` and ``good_us``: time
        for one in [us].
    """
    random_, sender = random.Random(seed), mavlink.MAVLink(None, SENDER, 1)
    heartbeat = mavlink.MAVLink_heartbeat_message(1, 3, 128, 15, mavlink.MAV_STATE_ACTIVE, 3)
    taken = lost = 0
    bad_time = good_time = 0.0
    for _ in range(count):
        good = bytes(heartbeat.pack(sender))
        sender.seq = (sender.seq + 1) % 256
        bad = changed(random_, good)
        begin = time.perf_counter()
        passed = connection.parse(bad)
        middle = time.perf_counter()
        read = connection.parse(good)
        good_time += time.perf_counter() - middle
        bad_time += middle - begin
        # A frame with bytes put before or after it is still a good one.
        taken += sum(message.to_dict() != heartbeat.to_dict() for message in passed)
        lost += [message.to_dict() for message in read] != [heartbeat.to_dict()]
    return {
        "bad": count,
        "taken": taken,
        "good_lost": lost,
        "bad_us": 1e6 * bad_time / count,
        "good_us": 1e6 * good_time / count,
    }
