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

r"""The six-degree-of-freedom aircraft: JSBSim with an airframe of ours, in SI units and ``map``.

JSBSim (Berndt, AIAA 2004-4923) integrates the equations of motion over the rotating ellipsoid of
WGS84 in the standard atmosphere of 1976. ``map`` is the plane that touches the ellipsoid at
:data:`LATITUDE`, East, North and Up.
"""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import root

from uav_tracking_mpc.settings.configuration import configuration_folder
from uav_tracking_mpc.settings.simulator import SimulatorParameters

RATE = 200  # Hz, of the equations of motion, the servos and the inner loops
LATITUDE = 0.25 * math.pi  # rad, where gravity is within 0.01 % of the standard
FOOT = 0.3048  # m
AIRFRAME = "aerosonde"
ALPHA_LOST = 0.6  # rad, at which the wing has long stalled
# m/s: W20, above which turbulence is moderate and severe, and JSBSim's index of how seldom it is
# exceeded, which counts above 1000 ft (MIL-F-8785C, figure 7).
SEVERITIES = ((0.0, 3), (11.5, 4), (19.3, 6))
AXES = ("x", "y", "z")
ACCELERATIONS = (
    *(f"{axis}dot-ft_sec2" for axis in "uvw"),
    *(f"{axis}dot-rad_sec2" for axis in "pqr"),
)
LEVEL = ("north", "east", "down")


class AirframeError(RuntimeError):
    """JSBSim is missing, or the aircraft cannot fly as it is told to."""


class Surfaces(NamedTuple):
    """What the servos are told.

    Attributes:
        aileron: Positive rolls to the right, in [rad].
        elevator: Positive lowers the nose, in [rad].
        rudder: Positive yaws to the left, in [rad].
        throttle: From 0 to 1, [-].
    """

    aileron: float
    elevator: float
    rudder: float
    throttle: float


class Flown(NamedTuple):
    """What an autopilot measures of the aircraft itself, in its own axes: forward, right, down.

    Attributes:
        bank: Positive to the right, in [rad].
        pitch: Positive nose up, in [rad].
        roll_rate: In [rad/s].
        pitch_rate: In [rad/s].
        yaw_rate: In [rad/s].
        airspeed: True airspeed in [m/s].
        path_angle: asin of the climb rate through the mean air over airspeed, in [rad].
        side_force: Specific force to the right in [m/s^2].
        lift: Specific force upwards in [m/s^2].
    """

    bank: float
    pitch: float
    roll_rate: float
    pitch_rate: float
    yaw_rate: float
    airspeed: float
    path_angle: float
    side_force: float
    lift: float


class Airframe:
    """One aircraft in the air, trimmed where it starts.

    Args:
        start: Position, heading, path angle, airspeed and air at the start.
        seed: Of the turbulence.

    Attributes:
        trim: Surfaces of the steady flight in which it starts.
        steps: Taken since the start.

    Raises:
        AirframeError: There is no steady flight to start from.
        ImportError: JSBSim is not installed.
    """

    def __init__(self, start: SimulatorParameters, seed: int = 0) -> None:
        self._fdm = _executive()
        self._fdm["ic/terrain-elevation-ft"] = 0.0
        self._climbing_air = start.wind[2]
        self._origin, self._axes = np.zeros(3), np.eye(3)
        self._place(LATITUDE, 0.0, 0.0)
        self._origin = self._from_centre()
        sin, cos = math.sin(LATITUDE), math.cos(LATITUDE)
        self._axes = np.array([[0.0, 1.0, 0.0], [-sin, 0.0, cos], [cos, 0.0, sin]])
        self._put(np.array(start.initial_position, dtype=float))
        self.trim = self._trimmed(start, seed)
        self.steps = 0

    def step(self, surfaces: Surfaces) -> None:
        """Fly on for one step of 1 / :data:`RATE`.

        Args:
            surfaces: What the servos are told.

        Raises:
            AirframeError: The aircraft stalls or spins beyond what its data describe.
        """
        self._command(surfaces)
        self._fdm.run()
        self.steps += 1
        alpha = self._fdm["aero/alpha-rad"]
        if not abs(alpha) < ALPHA_LOST:  # also where it is not a number
            raise AirframeError(
                f"control is lost: angle of attack {alpha:.3g} rad at {self.airspeed:.3g} m/s"
            )

    def blow(self, wind: Sequence[float], gust_intensity: float) -> None:
        """Let the air move otherwise from now on: the aircraft meets it as a gust.

        Args:
            wind: Mean velocity in ``map``, three, in [m/s].
            gust_intensity: W20 in [m/s].
        """
        east, north, up = wind
        for axis, speed in zip(LEVEL, (north, east, -up), strict=True):
            self._fdm[f"atmosphere/wind-{axis}-fps"] = speed / FOOT
        self._climbing_air = up
        self._stir(gust_intensity)

    @property
    def flown(self) -> Flown:
        """What its autopilot measures now."""
        fdm = self._fdm
        airspeed = self.airspeed
        climb = FOOT * fdm["velocities/h-dot-fps"] - self._climbing_air
        return Flown(
            bank=fdm["attitude/phi-rad"],
            pitch=fdm["attitude/theta-rad"],
            roll_rate=fdm["velocities/p-rad_sec"],
            pitch_rate=fdm["velocities/q-rad_sec"],
            yaw_rate=fdm["velocities/r-rad_sec"],
            airspeed=airspeed,
            path_angle=math.asin(min(max(climb / airspeed, -1.0), 1.0)),
            side_force=FOOT * fdm["accelerations/a-pilot-y-ft_sec2"],
            lift=-FOOT * fdm["accelerations/a-pilot-z-ft_sec2"],
        )

    @property
    def airspeed(self) -> float:
        """True airspeed in [m/s]."""
        return FOOT * self._fdm["velocities/vt-fps"]

    @property
    def height(self) -> float:
        """Above the ground at sea level in [m]."""
        return self._fdm["position/h-sl-meters"]

    @property
    def position(self) -> NDArray[np.float64]:
        """In ``map``, shape (3,), in [m]."""
        return self._axes @ (self._from_centre() - self._origin)

    @property
    def ground_velocity(self) -> NDArray[np.float64]:
        """In ``map``, shape (3,), in [m/s]."""
        parts = [self._fdm[f"velocities/ecef-{axis}-fps"] for axis in AXES]
        return self._axes @ (FOOT * np.array(parts))

    @property
    def wind(self) -> NDArray[np.float64]:
        """Velocity of the air with its gusts in ``map``, shape (3,), in [m/s]."""
        north, east, down = (self._fdm[f"atmosphere/total-wind-{axis}-fps"] for axis in LEVEL)
        return FOOT * np.array([east, north, -down])

    @property
    def yaw(self) -> float:
        """Of the nose, counter-clockwise from East, in [rad]."""
        return math.remainder(0.5 * math.pi - self._fdm["attitude/psi-rad"], 2.0 * math.pi)

    def _command(self, surfaces: Surfaces) -> None:
        fdm = self._fdm
        fdm["fcs/aileron-demand-rad"], fdm["fcs/elevator-demand-rad"] = surfaces[:2]
        fdm["fcs/rudder-demand-rad"], fdm["fcs/throttle-demand-norm"] = surfaces[2:]

    def _from_centre(self) -> NDArray[np.float64]:
        return FOOT * np.array([self._fdm[f"position/ecef-{axis}-ft"] for axis in AXES])

    def _place(self, latitude: float, longitude: float, height: float) -> None:
        self._fdm["ic/lat-geod-rad"], self._fdm["ic/long-gc-rad"] = latitude, longitude
        self._fdm["ic/h-sl-ft"] = height / FOOT
        self._fdm.run_ic()

    def _put(self, position: NDArray[np.float64]) -> None:
        """Find the latitude, longitude and height [m] of a position in ``map``."""
        guess = np.array([LATITUDE, 0.0, position[2]])
        radius = float(np.linalg.norm(self._origin))
        for _ in range(6):  # each takes the error down by a factor of a hundred or more
            self._place(*guess.tolist())
            east, north, up = (position - self.position).tolist()
            guess += [north / radius, east / radius / math.cos(guess[0]), up]
        self._place(*guess.tolist())

    def _trimmed(self, start: SimulatorParameters, seed: int) -> Surfaces:
        """Find angle of attack, bank and surfaces of straight flight, where nothing accelerates."""
        fdm, wind, airspeed = self._fdm, start.wind, start.initial_speed
        heading, path_angle = start.initial_heading, start.initial_path_angle
        level = airspeed * math.cos(path_angle)
        east = level * math.cos(heading) + wind[0]
        north = level * math.sin(heading) + wind[1]
        climb = airspeed * math.sin(path_angle)

        def begin(alpha: float, bank: float, surfaces: Surfaces, rising: float = 0.0) -> None:
            self._command(surfaces)
            fdm["ic/vw-mag-fps"] = math.hypot(*wind[:2]) / FOOT
            fdm["ic/vw-dir-deg"] = math.degrees(math.atan2(wind[0], wind[1])) % 360.0
            fdm["ic/phi-rad"], fdm["ic/theta-rad"] = bank, path_angle + alpha
            fdm["ic/psi-true-rad"] = (0.5 * math.pi - heading) % (2.0 * math.pi)
            fdm["ic/vn-fps"], fdm["ic/ve-fps"] = north / FOOT, east / FOOT
            fdm["ic/vd-fps"] = -(climb + rising) / FOOT
            fdm.set_trim_status(True)  # servos stand where they are told to
            fdm.run_ic()
            fdm.set_trim_status(False)

        def unbalanced(unknowns: NDArray[np.float64]) -> list[float]:
            alpha, bank, *surfaces = unknowns.tolist()
            begin(alpha, bank, Surfaces(*surfaces))
            return [fdm[f"accelerations/{part}"] for part in ACCELERATIONS]

        solved = root(unbalanced, [0.05, 0.0, 0.0, 0.0, 0.0, 0.6], tol=1e-10)
        alpha, bank, *parts = solved.x.tolist()
        surfaces = Surfaces(*parts)
        if not solved.success or not 0.0 <= surfaces.throttle <= 1.0 or abs(alpha) > ALPHA_LOST:
            raise AirframeError(
                f"there is no steady flight at {airspeed:g} m/s and a path angle of "
                f"{path_angle:g} rad"
            )
        fdm["simulation/randomseed"] = seed
        begin(alpha, bank, surfaces, rising=wind[2])
        fdm["atmosphere/wind-down-fps"] = -wind[2] / FOOT  # the start knows level wind alone
        fdm.suspend_integration()
        fdm.run()
        fdm.resume_integration()
        if start.gust_intensity > 0.0:
            self._stir(start.gust_intensity)
        return surfaces

    def _stir(self, intensity: float) -> None:
        """Set the strength of the turbulence, W20 [m/s]."""
        severity = max((index for above, index in SEVERITIES if intensity > above), default=0)
        turbulence = "atmosphere/turbulence/milspec"
        self._fdm[f"{turbulence}/windspeed_at_20ft_AGL-fps"] = intensity / FOOT
        self._fdm[f"{turbulence}/severity"] = severity


def _executive() -> Any:
    """JSBSim with the airframe loaded, silent."""
    os.environ.setdefault("JSBSIM_DEBUG", "0")  # read when the library makes its first executive
    try:
        import jsbsim
    except ImportError as error:
        raise ImportError(
            'JSBSim is not installed: pip install "uav_tracking_mpc[jsbsim]"'
        ) from error
    jsbsim.set_logger(jsbsim.DefaultLogger(jsbsim.LogLevel.ERROR))
    fdm = jsbsim.FGFDMExec(None)
    fdm.set_debug_level(0)
    fdm.set_aircraft_path(str(configuration_folder() / "airframes"))
    fdm.set_dt(1.0 / RATE)
    fdm.load_model(AIRFRAME)
    return fdm
