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

"""A controller on its problems: what its tests share."""

import numpy as np
import small_uav

from uav_tracking_mpc.control.controller import Controller
from uav_tracking_mpc.dynamics.relative import vehicle_state
from uav_tracking_mpc.estimation.navigator import Estimate
from uav_tracking_mpc.estimation.situation import Situation, steady_forecast
from uav_tracking_mpc.formulation.flight_formulation import FlightFormulation
from uav_tracking_mpc.formulation.formulation import Plan
from uav_tracking_mpc.mpc.solver import Solution, Status
from uav_tracking_mpc.settings.tracking import TrackingParameters

PAPER = TrackingParameters(solve_time_max=5.0)  # the load of the machine is not tested
FLIGHT = small_uav.parameters()


class Faulty:
    """A formulation whose plans are passed on until it is told otherwise.

    Attributes:
        status: What the solver is made to say; None for the truth.
        violation: Of hard constraints, with that status.
        error: Raised in the place of an answer.
    """

    def __init__(self, formulation):
        self.formulation = formulation
        self.solver, self.step, self.reset = formulation.solver, formulation.step, formulation.reset
        self.change, self.check, self.decrease = formulation.change, formulation.check, None
        self.respond, self.soften = formulation.respond, formulation.soften
        self.status = self.error = None
        self.violation = 0.0

    def solve(self, situation, forecast, orbit, elapsed):
        if self.error is not None:
            raise self.error
        plan = self.formulation.solve(situation, forecast, orbit, elapsed)
        if self.status is None:
            return plan
        changes = {"status": self.status, "message": "told to", "violation": self.violation}
        return plan._replace(solution=plan.solution._replace(**changes))


def estimate(now, stages=PAPER.horizon):
    return Estimate(now, now, steady_forecast(now, stages))


def words(controller):
    """What has been reported since the last call."""
    return [event.words for event in controller.events.take()]


def paper_situation(relative):
    vehicle = vehicle_state(relative, 0.4, np.zeros(3))
    return Situation(vehicle, np.zeros(3), np.zeros(3), np.zeros(3), np.zeros(3))


def flight_controller(parameters=FLIGHT):
    return Controller(parameters, FlightFormulation(parameters, small_uav.solver()))


def limits(parameters, airspeed):
    upper = parameters.input_upper
    upper[0] = parameters.envelope.turn_rate_max(airspeed)
    lower = parameters.input_lower
    lower[0] = -upper[0]
    return lower, upper


class Constant:
    """A formulation with one plan for everything, and a solver that is told when to fail."""

    solver = None
    step = 0.5

    def __init__(self, inputs):
        self.plan, self.converges = np.tile(inputs, (20, 1)), True

    def reset(self):
        pass

    def check(self, parameters):
        pass

    def change(self, parameters):
        pass

    def respond(self, response):
        pass

    def solve(self, situation, forecast, orbit, elapsed):
        status = Status.CONVERGED if self.converges else Status.FAILED
        nothing = np.zeros((0, 3))
        solution = Solution(status, "as told", 1.0, 1, 0.0, nothing, nothing, np.zeros(3), 0.0)
        return Plan(self.plan, self.step, np.zeros(5), solution)
