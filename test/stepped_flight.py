"""A controller flies a simulated autopilot through its link, in simulated time."""

import math

import numpy as np

from uav_tracking_mpc.autopilot.stepped_autopilot import SteppedAutopilot
from uav_tracking_mpc.control.controller import Controller
from uav_tracking_mpc.dynamics.orbit import Orbit
from uav_tracking_mpc.launch.preflight import with_envelope
from uav_tracking_mpc.parameters.registry import VEHICLE_LINK
from uav_tracking_mpc.settings.configuration import load_configuration
from uav_tracking_mpc.settings.link import LinkParameters
from uav_tracking_mpc.simulation.motions import motion_of

TARGET_PERIOD = 0.1  # s
# Near the orbit of small_uav, and along it.
NEAR = ("uav_simulator.initial_position=[280.0, 0.0, 118.0]", "uav_simulator.initial_heading=1.6")


class SteppedFlight:
    """Everything of a flight but the nodes: each state is answered when it comes.

    What is flown is kept in rows: time, range error, altitude error and bank.
    """

    def __init__(self, dialect, scenario="wind", settings=NEAR, link=None, **changed):
        settings = ("uav_simulator.state_rate=50.0", *settings)
        self.configuration = load_configuration("small_uav", settings, scenario)
        self.autopilot = SteppedAutopilot(dialect, self.configuration)
        for name, value in changed.items():
            assert self.autopilot.core.parameters.set(name, value)
        parameters = link or LinkParameters(link=dialect)
        kind = VEHICLE_LINK.find(dialect)
        self.link = kind(parameters=parameters, connection=self.autopilot.connection)
        self.motion = motion_of(self.configuration.target)
        self.rows, self.sent, self.words = [], [], []
        self._controller = None
        self._target_at = -math.inf
        take = self.autopilot.core.attitude_target

        def seen(target):
            self.sent.append((self.autopilot.time, target))
            take(target)

        self.autopilot.core.attitude_target = seen

    def connect(self):
        self.link.connect(10.0)
        return self

    @property
    def controller(self):
        if self._controller is None:
            envelope = self.link.inspect().envelope
            if self.link.holds:
                envelope = {"autopilot_holds": True, **envelope}
            self.fitted, _ = with_envelope(self.configuration, envelope, ())
            self._controller = Controller(self.fitted.controller, stopwatch=lambda: 0.0)
        return self._controller

    @property
    def time(self):
        return self.autopilot.time

    def fly(self, duration, commanding=True):
        """Until so much time has gone by."""
        controller, orbit = self.controller, self.controller.orbit
        end = self.time + duration
        while self.time < end:
            measured = self.link.measured(0.1)
            self.words += [event.words for event in self.link.events.take()]
            if measured is None or not commanding:
                continue
            controller.engage(self.link.engaged)
            now = self.link.now()
            if now - self._target_at >= TARGET_PERIOD - 1e-9:
                self._target_at = now
                controller.see_target(now, self.motion.position(now))
            command = controller.step(measured, now)
            if command is not None:
                self.link.command(command.stamp, command.inputs, command.step, command.flown_orbit)
            self._note(orbit)
        return self

    def _note(self, orbit: Orbit):
        state = self.autopilot.core.state
        target = self.motion.position(self.time)
        offset = np.array([state.east, state.north, state.up]) - target
        self.rows.append(
            (
                self.time,
                float(np.linalg.norm(offset)) - orbit.range,
                float(offset[2]) - orbit.altitude,
                state.roll,
            )
        )

    def engage(self, patience=8.0):
        """Ask for command and fly until it is there."""
        self.fly(0.5)
        refusal = self.link.engage()
        if refusal:
            return refusal
        end = self.time + patience
        while not self.link.engaged and self.time < end:
            self.fly(0.1)
        return "" if self.link.engaged else "not engaged in time"

    def since(self, time):
        """(range error, altitude error, roll rate) from a time on, each shape (n,)."""
        rows = np.array([row for row in self.rows if row[0] >= time])
        rates = np.diff(rows[:, 3]) / np.maximum(np.diff(rows[:, 0]), 1e-3)
        return rows[:, 1], rows[:, 2], rates
