r"""The return ratio of the loop that flies, measured in still air on the orbit.

The controller with all its estimators flies the plant twice: undisturbed, and with an impulse added
at the plant's input of one channel for one control period. What the commands differ by is the
loop's answer; with the impulse's size D in channel i,

.. math::

    S_{ji}(e^{i\omega T}) = \delta_{ji} + \frac{g_j}{D} \sum_k \Delta u_{j,k} e^{-i\omega T k},
    \qquad L = S^{-1} - I,

where :math:`g_j` is the gain of the plant's channel. Nothing is assumed of the controller but that
its answer to a small disturbance is linear, does not depend on the time, and dies away.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.dynamics.orbit import COUNTER_CLOCKWISE, Orbit
from uav_tracking_mpc.parameters.specification import changed
from uav_tracking_mpc.settings.configuration import Configuration
from uav_tracking_mpc.simulation.closed_loop import simulate
from uav_tracking_mpc.simulation.plants.vehicle import VehiclePlant

SETTLED = 60.0  # s after which a flight that begins on the orbit is steady
OBSERVED = 60.0  # s in which the answer to an impulse dies away
IMPULSES = np.array([0.1, 0.1, 1.0])  # rad/s, rad/s, m/s^2 for one control period
ROUNDING = 1e-6  # s


class DisturbedPlant(VehiclePlant):
    """The vehicle, with a pulse added at its input.

    Args:
        parameters: See :class:`VehiclePlant`.
        pulse: Added to (u_psi, u_chi, u_v), shape (3,), in [rad/s, rad/s, m/s^2].
        begin: When it begins in [s].
        duration: How long it lasts in [s].
    """

    def __init__(self, parameters, pulse, begin, duration):
        super().__init__(parameters)
        self._pulse, self._begin, self._end = pulse, begin - ROUNDING, begin + duration - ROUNDING

    def inputs(self):
        """See :meth:`VehiclePlant.inputs`."""
        inputs = super().inputs()
        if not self._begin <= self.time < self._end:
            return inputs
        turn, climb, gain = (np.array(inputs) + self._pulse).tolist()
        return turn, climb, gain


def flown(configuration, pulse):
    period = 1 / configuration.controller.control_rate
    plant = DisturbedPlant(configuration.simulator, pulse, SETTLED, period)
    return simulate(configuration, plant=plant)


def still(configuration):
    c = configuration
    d = configuration.controller.orbit.direction
    orbit = configuration.controller.orbit
    sense = 1.0 if orbit.direction == COUNTER_CLOCKWISE else -1.0
    simulator = replace(
        c.simulator,
        wind=(0.0, 0.0, 0.0),
        gust_intensity=0.0,
        position_noise=0.0,
        velocity_noise=0.0,
        attitude_noise=0.0,
        airspeed_noise=0.0,
        initial_position=(orbit.radius, 0.0, orbit.altitude),
        initial_heading=sense * math.pi / 2,
        initial_path_angle=0.0,
        initial_speed=orbit.speed,
    )
    target = replace(c.target, motion="stationary", position=(0.0, 0.0, 0.0), noise=0.0)
    controller = replace(c.controller, solve_time_max=10.0, direction=orbit.direction)
    mission = replace(c.mission, duration=SETTLED + OBSERVED, plant="vehicle")
    return replace(c, simulator=simulator, target=target, controller=controller, mission=mission)


def flown_loop(configuration, frequency, size=1.0):
    c = still(configuration)
    ref = flown(c, np.zeros(3))
    period = 1 / c.controller.control_rate
    begin = int(np.searchsorted(ref.command_time, SETTLED - ROUNDING))
    k = np.arange(len(ref.command_time) - begin)
    z = np.exp(-1j * np.outer(frequency * period, k))
    S = np.tile(np.eye(3, dtype=complex), (len(frequency), 1, 1))
    tails = []
    for axis in range(3):
        log = flown(c, size * IMPULSES * np.eye(3)[axis])
        delta = (log.inputs - ref.inputs)[begin:] * np.array(c.simulator.command_gain)
        tails.append((np.abs(delta).max(0), np.abs(delta[-200:]).max(0)))
        S[:, :, axis] += z @ delta / (size * IMPULSES[axis])
    return np.linalg.inv(S) - np.eye(3), tails, S
