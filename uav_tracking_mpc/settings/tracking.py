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

"""Parameters of the tracking controller (Table 1), each in the part that reads it.

=============================  =================================================================
:class:`ProblemParameters`     of both problems: orbit, horizon, weights, limits, solver
:class:`PaperParameters`       those and what the paper's problem (14)-(16) adds
:class:`FlightParameters`      those and what the flight problem adds: aircraft, artificial orbit
:class:`EstimationParameters`  of the estimators
:class:`TrackingParameters`    all of them, and what the controller itself reads
=============================  =================================================================

A problem is posed from its own part alone. Parameters of limits and of vehicle models are described
in the files of their owners and gathered here.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.dynamics import paper_numbers as paper
from uav_tracking_mpc.dynamics.orbit import CLOCKWISE, DIRECTIONS, Orbit
from uav_tracking_mpc.dynamics.relative import steady_inputs
from uav_tracking_mpc.dynamics.vehicle import Response
from uav_tracking_mpc.dynamics.vehicle_models import VEHICLE_MODEL, VehicleModel
from uav_tracking_mpc.limits import LIMIT, Limit
from uav_tracking_mpc.limits.envelope import Envelope
from uav_tracking_mpc.mpc.problem import TERMINAL_CONSTRAINTS
from uav_tracking_mpc.parameters.registry import ExtensionError
from uav_tracking_mpc.parameters.specification import (
    ParameterError,
    Parameters,
    from_mapping,
    gathered,
    parameter,
    taken,
)
from uav_tracking_mpc.settings.frame_parameters import FrameParameters
from uav_tracking_mpc.symbolic.functions import SCHEMES

ARTIFICIAL_ORBIT = "artificial_orbit"  # terminal_constraint: of the flight problem
# rad/s, rad/s, m/s^2: test signal of 8 deg of bank, 5 deg of path angle, 10 % of airspeed.
USUAL_EXCITATION = (0.06, 0.11, 1.5)
USUAL_AIRSPEED = 22.0  # m/s, for which it is that large
NEAREST = "nearest"  # direction: the nearer one where the flight begins
PREDICTIVE = "nmpc"  # law: none, the optimal control problem is solved
LAGGED, HELD = "lagged", "held"  # vehicle models, all inputs commanded and the bank alone
SOLVERS = ("newton", "ipopt")
DEAD_TIMES_APART = 0.2  # s, of two channels; with 0.4 the loop may swing
LimitParameters: Any = gathered("LimitParameters", LIMIT.own().values())
ModelParameters: Any = gathered("ModelParameters", VEHICLE_MODEL.own().values())


@dataclass(frozen=True)
class ProblemParameters(LimitParameters):
    """Parameters of both problems, those of the limits among them."""

    range: float = parameter(
        paper.ORBIT.range, "Distance to the target to hold, r_d.", "m", 1.0, 1e5
    )
    altitude: float = parameter(
        paper.ORBIT.altitude, "Height above the target to hold, z_d.", "m", -1e4, 1e4
    )
    airspeed: float = parameter(paper.ORBIT.speed, "Speed to hold, v_d.", "m/s", 0.1, 300.0)
    direction: str = parameter(
        "clockwise",
        "Sense of the orbit seen from above; nearest needs the artificial orbit.",
        choices=(*DIRECTIONS, NEAREST),
    )
    horizon: int = parameter(
        paper.HORIZON, "Stages of the horizon, N.", lower=1, upper=200, fixed=True
    )
    horizon_step: float = parameter(
        paper.STEP, "Time from stage to stage, T_s.", "s", 0.001, 10.0, fixed=True
    )
    control_rate: float = parameter(10.0, "How often a new command is computed.", "Hz", 0.1, 1000.0)
    state_weights: tuple[float, ...] = parameter(
        paper.STATE_WEIGHTS,
        "Diagonal of Q: range, bearing, altitude, path angle, speed.",
        size=5,
        lower=1e-9,
        upper=1e9,
    )
    input_weights: tuple[float, ...] = parameter(
        paper.INPUT_WEIGHTS,
        "Diagonal of R: yaw rate, pitch rate, acceleration.",
        size=3,
        lower=1e-9,
        upper=1e9,
    )
    terminal_constraint: str = parameter(
        "none",
        "End of every plan: free, the paper's set (16e) penalised exactly or enforced, or an "
        "orbit that the optimiser chooses (for wind, moving targets, envelope and lag).",
        choices=(*TERMINAL_CONSTRAINTS, ARTIFICIAL_ORBIT),
        fixed=True,
    )
    solver: str = parameter(
        "newton", "Solver of the optimal control problem.", choices=SOLVERS, fixed=True
    )
    solve_time_max: float = parameter(
        0.05, "Budget of one solve; past it the earlier plan is flown.", "s", 1e-4, 10.0
    )

    @property
    def orbit(self) -> Orbit:
        """The reference; clockwise where the nearest direction is to be chosen.

        Raises:
            ParameterError: It is no circle.
        """
        direction = CLOCKWISE if self.direction == NEAREST else self.direction
        try:
            return Orbit(self.range, self.altitude, self.airspeed, direction)
        except ValueError as error:
            raise ParameterError(f"parameters 'range', 'altitude', 'airspeed': {error}") from error

    @property
    def input_lower(self) -> NDArray[np.float64]:
        """Lower bounds of (u_psi, u_chi, u_v), shape (3,)."""
        return np.array([-self.yaw_rate_max, -self.pitch_rate_max, self.acceleration_min])

    @property
    def input_upper(self) -> NDArray[np.float64]:
        """Upper bounds of (u_psi, u_chi, u_v), shape (3,)."""
        return np.array([self.yaw_rate_max, self.pitch_rate_max, self.acceleration_max])


@dataclass(frozen=True)
class PaperParameters(ProblemParameters):
    """Parameters of :class:`~uav_tracking_mpc.formulation.paper_formulation.PaperFormulation`.

    Raises:
        ParameterError: The inputs cannot hold the orbit.
    """

    model: str = parameter(
        "exact",
        "Prediction model: exact, or the paper's (11) or (9).",
        extension="uav_tracking_mpc.dynamics.relative_models",
        fixed=True,
    )
    scheme: str = parameter(
        "euler", "Discretisation of the model.", choices=tuple(SCHEMES), fixed=True
    )
    terminal_scaling: float = parameter(
        paper.SCALING, "rho: terminal weight P_rho = rho P.", lower=1.0, upper=1e3
    )
    terminal_penalty: float = parameter(
        100.0, "Weight of a violation of the soft terminal set.", lower=1e-3, upper=1e6
    )
    certificate: str = parameter(
        "",
        "File of the terminal set's certificate; empty for those that come with the package.",
        fixed=True,
    )

    def __post_init__(self) -> None:
        """Check that u_ss is inside U."""
        super().__post_init__()
        orbit = self.orbit  # one that is no circle is not the model's fault
        try:
            turn_rate = abs(steady_inputs(self.model, orbit)[0])
        except Exception as error:  # of a user's model
            raise ParameterError(f"parameter 'model' is {self.model!r}: {error}") from error
        if turn_rate >= self.yaw_rate_max:
            raise ParameterError(
                f"parameter 'yaw_rate_max' is {self.yaw_rate_max:.6g}, must exceed "
                f"{turn_rate:.6g} rad/s, the steady turn rate of an orbit of radius "
                f"{orbit.radius:.6g} m at {self.airspeed:.6g} m/s"
            )

    @property
    def steady_inputs(self) -> NDArray[np.float64]:
        """u_ss of the prediction model, shape (3,), in [rad/s, rad/s, m/s^2]."""
        return steady_inputs(self.model, self.orbit)


@dataclass(frozen=True)
class FlightParameters(ModelParameters, ProblemParameters):
    """Parameters of :class:`~uav_tracking_mpc.formulation.flight_formulation.FlightFormulation`.

    Raises:
        ParameterError: The limits do not allow the orbit, or contradict each other.
    """

    rate_weights: tuple[float, ...] = parameter(
        (0.0, 0.0, 0.0),
        "Of the rates of change of turn rate, path-angle rate and acceleration, with the "
        "artificial orbit. With autopilot_holds the first counts four times in calm air, sixteen "
        "times from moderate gusts on.",
        size=3,
        lower=0.0,
        upper=1e9,
    )
    airspeed_band: float = parameter(
        0.15,
        "Share of the wanted airspeed by which plans leave it unless a limit or the drift forces "
        "them, with the artificial orbit.",
        lower=0.01,
        upper=10.0,
    )
    offset_weights: tuple[float, ...] = parameter(
        (0.06, 0.5, 2.0),
        "Of the artificial orbit's distance to the wanted one: range, altitude, airspeed.",
        size=3,
        lower=1e-9,
        upper=1e9,
    )
    limit_penalty: float = parameter(
        1000.0,
        "Weight of a violated limit of airspeed (per m/s), path angle (per 0.1 rad), height or "
        "distance (per 5 m) or fence (per 10 m).",
        lower=1.0,
        upper=1e6,
        fixed=True,
    )
    limits: str = parameter(
        "",
        "Further limits, comma-separated: names of installed ones, or path.py:Class. One that is "
        "not named is not in force.",
        fixed=True,
    )
    vehicle_model: str = parameter(
        LAGGED,
        "Model of the aircraft, with the artificial orbit.",
        extension="uav_tracking_mpc.dynamics.vehicle_models",
        fixed=True,
    )
    autopilot_holds: bool = parameter(
        False,
        "The autopilot itself holds altitude and airspeed, by hold_time and so on: the controller "
        "commands the bank alone, with the artificial orbit.",
        fixed=True,
    )
    dead_time: tuple[float, ...] = parameter(
        (0.0, 0.0, 0.0),
        "Time until a command of turn rate, path-angle rate, acceleration begins to act.",
        "s",
        0.0,
        2.0,
        size=3,
    )

    def __post_init__(self) -> None:
        """Check orbit and model of the aircraft against what it can do."""
        super().__post_init__()
        orbit = self.orbit
        try:
            refusal = self.envelope.refusal(orbit, np.zeros(3))
        except ValueError as error:
            raise ParameterError(f"the limits contradict each other: {error}") from error
        if refusal:
            raise ParameterError(f"parameters 'range', 'altitude', 'airspeed': {refusal}")
        if self.autopilot_holds is (self.vehicle.commanded == len(self.input_lower)):
            raise ParameterError(
                f"parameter 'autopilot_holds' is {str(self.autopilot_holds).lower()}, must not be "
                f"with vehicle_model '{self.vehicle_model}'"
            )

    @cached_property
    def envelope(self) -> Envelope:
        """Limits of the aircraft and of where it may fly."""
        further = _further_limits(self.limits)
        owners = (*LIMIT.own().values(), *further)
        names = {field.name for owner in owners for field in dataclasses.fields(owner)}
        return Envelope(further, **{name: getattr(self, name) for name in names})

    @cached_property
    def vehicle(self) -> VehicleModel:
        """Model of the aircraft that plans are made with."""
        model = self.vehicle_model
        if self.autopilot_holds and model == LAGGED:
            model = HELD
        return taken(VEHICLE_MODEL.find(model), self)

    @property
    def response(self) -> Response:
        """How the aircraft answers commands, as told; no dead time in what the autopilot finds."""
        dead_times = np.array(self.dead_time)
        dead_times[self.vehicle.commanded :] = 0.0
        return Response(self.vehicle.lags, dead_times, np.ones(3))

    def flown_by(self, response: Response) -> Response:
        """What plans are made with: the lag of a channel that answers much earlier is dead time.

        A plan begins when the last channel answers. If the commands of another one have acted long
        before, each plan takes back what the one before it has just sent, and the loop swings with
        every command.

        Args:
            response: Of the aircraft.
        """
        lags, dead_times, gains = response
        longer = np.maximum(dead_times, dead_times.max() - DEAD_TIMES_APART)
        longer[self.vehicle.commanded :] = 0.0
        quicker = self.vehicle.with_lags(np.maximum(lags - (longer - dead_times), 0.0))
        return Response(quicker.lags, longer, gains)


@dataclass(frozen=True)
class EstimationParameters(Parameters):
    """Parameters of the estimators, and margins that are asked of what they find."""

    response_estimation: bool = parameter(
        False,
        "Estimate lag, dead time and gain in flight, and bank and force where the aircraft gives "
        "less than was told, and fly by them; needs the artificial orbit.",
    )
    excitation: tuple[float, ...] = parameter(
        (0.0, 0.0, 0.0),
        "Amplitudes of a test signal on turn rate, path-angle rate, acceleration once the flight "
        "has settled, in their units; 0 for none. For `identify`.",
        lower=0.0,
        upper=5.0,
        size=3,
    )
    state_timeout: float = parameter(
        0.5, "Age at which the vehicle's state counts as lost.", "s", 0.01, 60.0
    )
    target_timeout: float = parameter(
        5.0, "Age at which the target's position counts as lost.", "s", 0.01, 600.0
    )
    target_noise: float = parameter(
        0.1,
        "Standard deviation of the target's measured position, until it is found in flight.",
        "m",
        1e-3,
        1e3,
    )
    target_agility: float = parameter(
        0.5, "How hard the target accelerates, until it is found in flight.", "m/s^2", 1e-3, 100.0
    )
    air_estimation: bool = parameter(
        False,
        "Estimate mean wind, gusts, noise and biases of the sensors; else measurements count as "
        "they are.",
        fixed=True,
    )
    delay_margin_min: float = parameter(
        0.3,
        "Delay that the closed loop shall bear in each channel beyond what it is told; a warning "
        "is given where it is less.",
        "s",
        0.0,
        10.0,
    )
    gain_margin_min: float = parameter(
        6.0, "Likewise of the gain of each channel, up and down.", "dB", 0.0, 60.0
    )


@dataclass(frozen=True)
class TrackingParameters(FrameParameters, EstimationParameters, FlightParameters, PaperParameters):
    """What the controller is asked to do. The defaults are those of the paper's Table 1 and (59).

    ``terminal_constraint`` says which problem is flown, ``law`` whether any is; ``limits`` and
    ``vehicle_model`` may bring more parameters.

    Raises:
        ParameterError: The values do not fit together: no such orbit, inputs that cannot hold it,
            or what the problem that is flown does not know.
    """

    law: str = parameter(
        PREDICTIVE,
        "What is flown: the predictive controller, or a guidance law.",
        choices=(PREDICTIVE,),
        extension="uav_tracking_mpc.laws",
        fixed=True,
    )
    plan_age_max: float = parameter(
        2.0, "How long an earlier plan may stand in for a solve that failed.", "s", 0.0, 60.0
    )
    record: str = parameter(
        "", "File to record what the controller is given and answers; empty for none.", fixed=True
    )
    autostart: bool = parameter(
        True, "Configure and activate at the start; else a lifecycle manager does.", fixed=True
    )

    def __post_init__(self) -> None:
        """Refuse what the problem that is flown does not know."""
        super().__post_init__()
        if self.terminal_constraint == ARTIFICIAL_ORBIT:
            if self.model != "exact":
                raise ParameterError(
                    f"parameter 'model' is '{self.model}', must be 'exact' with "
                    f"terminal_constraint '{ARTIFICIAL_ORBIT}'"
                )
            return
        held = self.autopilot_holds and self.law == PREDICTIVE
        rules = (
            ("autopilot_holds", held, "true", "false"),
            ("response_estimation", self.response_estimation, "true", "false"),
            ("rate_lag", any(self.rate_lag), list(self.rate_lag), "all 0"),
            ("dead_time", any(self.dead_time), list(self.dead_time), "all 0"),
            ("direction", self.direction == NEAREST, f"'{NEAREST}'", " or ".join(DIRECTIONS)),
        )
        for name, broken, value, wanted in rules:
            if broken:
                raise ParameterError(
                    f"parameter '{name}' is {value}, must be {wanted} unless terminal_constraint "
                    f"is '{ARTIFICIAL_ORBIT}'"
                )

    @classmethod
    def extended(cls, values: Mapping[str, Any]) -> type[TrackingParameters]:
        """This class, with the parameters of further limits and of another vehicle model.

        Args:
            values: Parameters by name, of which ``limits`` and ``vehicle_model`` count.

        Raises:
            ParameterError: There is no such limit or model.
        """
        names = [str(values.get("limits", "")), str(values.get("vehicle_model", LAGGED))]
        try:
            owners = (*_further_limits(names[0]), VEHICLE_MODEL.find(names[1]))
        except ExtensionError as error:
            raise ParameterError(f"parameters 'limits', 'vehicle_model': {error}") from error
        return _extended(owners)

    def __reduce__(self) -> tuple[Any, ...]:
        """Another process loads the extensions again."""
        return from_mapping, (TrackingParameters, dataclasses.asdict(self))


def usual_excitation(airspeed: float) -> tuple[float, float, float]:
    """Amplitudes of a test signal of no more bank, load and share of the airspeed than usual.

    Args:
        airspeed: That is flown in [m/s].

    Returns:
        Of turn rate, path-angle rate and acceleration in [rad/s, rad/s, m/s^2].
    """
    turn, path, acceleration = USUAL_EXCITATION
    slower, faster = min(airspeed / USUAL_AIRSPEED, 1.0), min(USUAL_AIRSPEED / airspeed, 1.0)
    return turn * faster, path * faster, acceleration * slower


def _further_limits(names: str) -> list[type[Limit]]:
    """Classes of the named limits, each once, without the project's own, which hold anyway."""
    named = dict.fromkeys(LIMIT.find(name.strip()) for name in names.split(",") if name.strip())
    return [limit for limit in named if limit not in LIMIT.own().values()]


@lru_cache
def _extended(owners: tuple[type, ...]) -> type[TrackingParameters]:
    gathered("All", (TrackingParameters, *owners))  # refuses one name for two parameters
    known = {field.name for field in dataclasses.fields(TrackingParameters)}
    more = [owner for owner in owners if {f.name for f in dataclasses.fields(owner)} - known]
    if not more:
        return TrackingParameters
    base = (TrackingParameters, gathered("Further", more))
    return dataclass(frozen=True)(type("TrackingParameters", base, {}))
