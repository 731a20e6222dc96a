"""What may be other than the controller was told: one name each, as overrides of a scenario."""

from __future__ import annotations

import math
from dataclasses import replace

from uav_tracking_mpc.settings.configuration import Configuration, load_configuration

SCENARIO = "crosswind"
DURATION, SETTLED_AFTER = 300.0, 90.0  # s, of a flight and until it counts
LAG_SHARES = (0.0, 0.25, 0.5, 0.75, 1.5, 2.0, 3.0)  # of the true lag and dead time that are told
GUSTS = {"light": 7.7, "moderate": 15.4, "severe": 23.2}  # W20 in [m/s]

_SIMULATOR, _TARGET, _CONTROLLER = "uav_simulator", "target_publisher", "nmpc_controller"
_MISTAKEN: dict[str, dict[str, object]] = {
    "late_0.1": {f"{_SIMULATOR}.state_delay": 0.1, f"{_SIMULATOR}.state_stamp_true": False},
    "late_0.3": {f"{_SIMULATOR}.state_delay": 0.3, f"{_SIMULATOR}.state_stamp_true": False},
    "stamped_0.3": {f"{_SIMULATOR}.state_delay": 0.3},
    **{
        f"noise_{noise:g}": {f"{_TARGET}.noise": noise, f"{_TARGET}.rate": 5.0}
        for noise in (0.5, 2.0, 5.0)
    },
    "wind_bias_2": {f"{_SIMULATOR}.velocity_bias": [2.0, 0.0, 0.0]},
    "heading_bias_5": {f"{_SIMULATOR}.heading_bias": math.radians(5.0)},
    "airspeed_bias_2": {f"{_SIMULATOR}.airspeed_bias": 2.0},
    "turn_rate_bias_2": {f"{_SIMULATOR}.turn_rate_bias": math.radians(2.0)},
    **{f"gust_{name}": {f"{_SIMULATOR}.gust_intensity": w20} for name, w20 in GUSTS.items()},
    "tight_gale": {f"{_CONTROLLER}.range": 180.0, f"{_SIMULATOR}.wind": [-12.0, 0.0, 0.0]},
    "zigzag": {f"{_TARGET}.motion": "zigzag"},
    "sensor_noise": {
        f"{_SIMULATOR}.velocity_noise": 0.3,
        f"{_SIMULATOR}.attitude_noise": math.radians(0.5),
        f"{_SIMULATOR}.airspeed_noise": 0.3,
    },
}  # fmt: skip
MISMATCHES = (*(f"lag_{share:g}" for share in LAG_SHARES), *_MISTAKEN)


def mismatched(config: str, name: str, overrides: tuple[str, ...] = ()) -> Configuration:
    """The flight of a mismatch.

    Args:
        config: Name or file of the configuration.
        name: One of :data:`MISMATCHES`.
        overrides: ``SECTION.PARAMETER=VALUE`` each; the mismatch comes on top.

    Raises:
        ParameterError: As of :func:`load_configuration`.
    """
    told = [f"{key}={value}" for key, value in _MISTAKEN.get(name, {}).items()]
    told.append(f"mission.duration={DURATION:g}")
    configuration = load_configuration(config, [*overrides, *told], SCENARIO)
    if name in _MISTAKEN:
        return configuration
    share, truth = float(name.removeprefix("lag_")), configuration.simulator
    controller = replace(
        configuration.controller,
        rate_lag=tuple(share * lag for lag in truth.rate_lag),
        dead_time=tuple(share * lag for lag in truth.dead_time),
    )
    return replace(configuration, controller=controller)
