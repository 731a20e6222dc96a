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

"""A simulated autopilot flown through its link in simulated time, by a controller or a plan."""

import contextlib
import math

import numpy as np

from uav_tracking_mpc.autopilot.simulated_autopilot import SteppedAutopilot
from uav_tracking_mpc.control.controller import Controller
from uav_tracking_mpc.dynamics.orbit import FlownOrbit
from uav_tracking_mpc.estimation.measurement import MeasurementError
from uav_tracking_mpc.launch.preflight import with_envelope
from uav_tracking_mpc.links import VEHICLE_LINK
from uav_tracking_mpc.settings.configuration import load_configuration
from uav_tracking_mpc.settings.link import LinkParameters
from uav_tracking_mpc.simulation.motions import motion_of

TARGET_PERIOD = 0.1  # s
# Near the orbit of small_uav, and along it.
NEAR = ("uav_simulator.initial_position=[280.0, 0.0, 118.0]", "uav_simulator.initial_heading=1.6")
ORBIT = FlownOrbit(np.array([0.0, 0.0, 120.0]), np.zeros(3), 275.0, 22.0)
TURN = np.tile([0.08, 0.0, 0.0], (10, 1))  # 4 s of it, along the orbit
STEP = 0.4  # s


class Planner:
    """Answers every state with the same turn, about an orbit that may move to the East."""

    def __init__(self, orbit=ORBIT, speed=0.0):
        self.orbit, self.speed, self.states = orbit, speed, 0

    def answer(self, flown, measured):
        centre = self.orbit.centre + np.array([self.speed * flown.time, 0.0, 0.0])
        flown.link.command(measured.stamp, TURN, STEP, self.orbit._replace(centre=centre))
        self.states += 1


class Nobody:
    """Says nothing."""

    def answer(self, flown, measured):
        pass


class ByController:
    """Flies the configuration's orbit about its target; rows are range and altitude error, bank."""

    def __init__(self, flown):
        envelope = flown.link.inspect().envelope
        envelope = {"autopilot_holds": flown.link.holds, **envelope}
        self.configuration, _ = with_envelope(flown.configuration, envelope)
        self.controller = Controller(self.configuration.controller, stopwatch=lambda: 0.0)
        self._motion = motion_of(self.configuration.target)
        self._target_at = -math.inf
        self.rows, self.words = [], []

    def answer(self, flown, measured):
        now = flown.link.now()
        if now - self._target_at >= TARGET_PERIOD - 1e-9:
            self._target_at = now
            with contextlib.suppress(MeasurementError):  # the state is old
                self.controller.see_target(now, self._motion.position(now))
        self.controller.engage(flown.link.engaged)
        command = self.controller.step(measured, now)
        self.words += [event.words for event in self.controller.events.take()]
        if command is not None:
            flown.link.command(command.stamp, command.inputs, command.step, command.flown_orbit)
        state, orbit = flown.autopilot.core.state, self.controller.orbit
        offset = [state.east, state.north, state.up] - self._motion.position(flown.time)
        distance = float(np.linalg.norm(offset))
        errors = distance - orbit.range, float(offset[2]) - orbit.altitude
        self.rows.append((flown.time, *errors, state.roll))

    def since(self, time):
        """RMS of range error [m], altitude error [m] and roll rate [deg/s]."""
        at, distance, height, bank = np.array([row for row in self.rows if row[0] >= time]).T
        rates = np.degrees(np.diff(bank) / np.maximum(np.diff(at), 1e-3))
        return [float(np.sqrt(np.mean(values**2))) for values in (distance, height, rates)]


class SteppedFlight:
    """Everything of a flight but the nodes.

    ``sent`` has time and content of every set-point as it arrives, ``words`` what was reported.
    """

    def __init__(
        self, dialect, scenario="wind", link=None, config="small_uav", near=NEAR, **changed
    ):
        settings = ("uav_simulator.state_rate=50.0", *near)
        self.configuration = load_configuration(config, settings, scenario)
        self.autopilot = SteppedAutopilot(dialect, self.configuration)
        for name, value in changed.items():
            assert self.autopilot.core.parameters.set(name, value)
        parameters = link or LinkParameters(link=dialect)
        connection = self.autopilot.connection
        self.link = VEHICLE_LINK.find(dialect)(parameters=parameters, connection=connection)
        self.sent, self.words = [], []
        take = self.autopilot.core.attitude_target

        def seen(target):
            self.sent.append((self.autopilot.time, target))
            take(target)

        self.autopilot.core.attitude_target = seen
        self.link.connect(10.0)

    @property
    def time(self):
        return self.autopilot.time

    def shake(self, nose, climb, roll=0.0):
        """Turbulence in what is told: rates of nose and roll [rad/s], the climb [m/s].

        Told 50 times a second; a roll that swings in is ``uav_simulator.roll_frequency``.
        """
        send, random_ = self.autopilot.radio.send, np.random.default_rng(1)
        shaking = {  # correlation time [s], standard deviation in the message's unit
            "ATTITUDE": {"pitchspeed": (0.1, nose), "rollspeed": (0.1, roll)},
            "GLOBAL_POSITION_INT": {"vz": (0.7, 100.0 * climb)},
        }
        values = dict.fromkeys(("pitchspeed", "rollspeed", "vz"), 0.0)

        def shaken(message):
            for field, (correlation, deviation) in shaking.get(message.get_type(), {}).items():
                kept = math.exp(-0.02 / correlation)
                noise = math.sqrt(1.0 - kept**2) * deviation * random_.normal()
                values[field] = kept * values[field] + noise
                told = getattr(message, field)
                setattr(message, field, type(told)(told + values[field]))
            send(message)

        self.autopilot.radio.send = shaken

    def fly(self, duration, by=None):
        """Until so much time has gone by."""
        by, end = by or Planner(), self.time + duration
        while self.time < end:
            measured = self.link.measured(0.1)
            self.words += [event.words for event in self.link.events.take()]
            if measured is not None:
                by.answer(self, measured)
        return self

    def engage(self, by=None, patience=8.0):
        """Ask for command and fly until it is there; gives why it is not."""
        self.fly(0.3, by)
        if refusal := self.link.engage():
            return refusal
        end = self.time + patience
        while not self.link.engaged and self.time < end:
            self.fly(0.1, by)
        return "" if self.link.engaged else "not engaged in time"

    def sent_after(self, time):
        """Times of the set-points after a time."""
        return [at for at, _ in self.sent if at > time + 1e-6]


def flight(dialect, **changed):
    """A flight that begins as an operator has set its autopilot up."""
    usual = {"COM_OBL_RC_ACT": 5} if dialect == "px4" else {}
    return SteppedFlight(dialect, **{**usual, **changed})


def engaged_flight(dialect):
    """A flight whose commands are flown already."""
    flown = flight(dialect)
    assert flown.engage() == ""
    return flown
