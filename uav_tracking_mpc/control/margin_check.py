"""Stability margins of the closed loop about the orbit, from the controller's own answers there."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from uav_tracking_mpc.control.guidance import formulation_of, law_of
from uav_tracking_mpc.control.orbit_deviation import SIZE, STEPS, FrozenOrbit
from uav_tracking_mpc.control.sampled_loop import Response, SampledLoop, sampled_loop
from uav_tracking_mpc.dynamics.orbit import Orbit
from uav_tracking_mpc.estimation.forecast import steady_forecast
from uav_tracking_mpc.estimation.situation import Situation
from uav_tracking_mpc.settings.tracking import TrackingParameters

Guidance = Callable[[Situation], NDArray[np.float64]]


class LocalLoops:
    def __init__(self, parameters, formulation=None):
        law = law_of(parameters)
        self.parameters = replace(parameters, solve_time_max=10.0)
        self._law = None if law is None else law(parameters.orbit, parameters.envelope)
        self._formulation = formulation or formulation_of(self.parameters)
        self.told = Response(np.array(parameters.vehicle.lags), np.array(parameters.dead_time))

    def _answer(self, situation, orbit, elapsed):
        if self._law is not None:
            return np.asarray(self._law.inputs(situation), dtype=float)
        ahead = steady_forecast(situation, self.parameters.horizon)
        plan = self._formulation.solve(situation, ahead, orbit, elapsed)
        if not plan.solution.converged:
            raise ArithmeticError(plan.solution.message)
        return plan.inputs[0]

    def gain(self, frozen):
        if self._formulation is not None:
            self._formulation.reset()
        self._answer(frozen.situation(np.zeros(SIZE)), frozen.orbit, None)
        columns = []
        for step, unit in zip(STEPS, np.eye(SIZE)):
            up, down = (self._answer(frozen.situation(s * step * unit), frozen.orbit, 0.0) for s in (1, -1))
            columns.append((up - down) / (2 * step))
        return np.array(columns).T

    def loop(self, frozen, plant=None):
        plant = plant or self.told
        predicted = None if self._law is not None else frozen.dynamics(self.told.lags)
        return sampled_loop(1/self.parameters.control_rate, self.gain(frozen), frozen.dynamics(plant.lags), plant, self.told, predicted)
