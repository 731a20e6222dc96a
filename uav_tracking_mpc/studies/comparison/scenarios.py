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

"""What is compared, by name: laws, scenarios, and mismatches as overrides of a scenario.

Their names are in the help of commands: nothing is imported here that takes long.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from uav_tracking_mpc.parameters.registry import names_of
from uav_tracking_mpc.parameters.specification import ParameterError
from uav_tracking_mpc.settings.configuration import (
    Configuration,
    load_configuration,
    scenario_names,
)
from uav_tracking_mpc.settings.tracking import PREDICTIVE
from uav_tracking_mpc.studies.comparison.sensor_faults import SENSOR_FAULTS, Changes

# From easy to hard; scenarios that are not named come after these.
ORDER = (
    "still", "wind", "crosswind", "headwind", "tight_headwind", "circling_target", "gusts",
    "noisy_target",
)  # fmt: skip


def law_names() -> list[str]:
    """The predictive controller and every law that is installed."""
    return [PREDICTIVE, *names_of("uav_tracking_mpc.laws")]


def law_label(law: str) -> str:
    """What tables and figures call a law.

    Args:
        law: A name, or ``path.py:Class``.

    Raises:
        ExtensionError: There is no such law.
    """
    if ":" not in law:
        return law
    from uav_tracking_mpc.laws import GUIDANCE_LAW

    return str(GUIDANCE_LAW.find(law).name)


def law_labels(laws: Sequence[str]) -> list[str]:
    """What tables and figures call some laws.

    Args:
        laws: Names, or ``path.py:Class``.

    Raises:
        ExtensionError: There is no such law.
        ParameterError: Two have one name.
    """
    labels = [law_label(law) for law in laws]
    if len(set(labels)) < len(labels):
        raise ParameterError(f"laws are {', '.join(labels)}, each must have a name of its own")
    return labels


SCENARIO = "crosswind"
DURATION, SETTLED_AFTER = 300.0, 90.0  # s, of a flight and until it counts
LAG_SHARES = (0.0, 0.25, 0.5, 0.75, 1.5, 2.0, 3.0)  # -, of lag and dead time, as configured
GUSTS = {"light": 7.7, "moderate": 15.4, "severe": 23.2}  # m/s: W20
NOISES = (0.5, 2.0, 5.0)  # m, noise of the target's position
SEEDS = range(5)  # of gusts: the worst flight counts
GUSTY_LAG_SHARES = (0.0, 0.25, 0.5, 2.0, 3.0)  # -, told in moderate gusts
LATER, DELAYS = 120.0, (100, 200, 400)  # s from which on commands are delayed, and by how many ms
ROLL = 3.0, 0.6  # rad/s and -, frequency and damping of a roll that is told as a lag
WEAVING_PERIODS = (4.0, 8.0, 12.0)  # s

_SIMULATOR, _TARGET, _CONTROLLER = "uav_simulator", "target_publisher", "nmpc_controller"
_MISTAKEN: dict[str, dict[str, object]] = {
    "late_0.1": {f"{_SIMULATOR}.state_delay": 0.1, f"{_SIMULATOR}.state_stamp_true": False},
    "late_0.3": {f"{_SIMULATOR}.state_delay": 0.3, f"{_SIMULATOR}.state_stamp_true": False},
    "stamped_0.3": {f"{_SIMULATOR}.state_delay": 0.3},
    **{f"noise_{noise:g}": {f"{_TARGET}.noise": noise, f"{_TARGET}.rate": 5.0} for noise in NOISES},
    "wind_bias_2": {f"{_SIMULATOR}.velocity_bias": [2.0, 0.0, 0.0]},
    "heading_bias_5": {f"{_SIMULATOR}.heading_bias": math.radians(5.0)},
    "airspeed_bias_2": {f"{_SIMULATOR}.airspeed_bias": 2.0},
    "turn_rate_bias_2": {f"{_SIMULATOR}.turn_rate_bias": math.radians(2.0)},
    **{f"gust_{name}": {f"{_SIMULATOR}.gust_intensity": w20} for name, w20 in GUSTS.items()},
    "second_order_roll": {
        f"{_SIMULATOR}.roll_frequency": ROLL[0],
        f"{_SIMULATOR}.roll_damping": ROLL[1],
    },
    "weaving_target": {f"{_TARGET}.motion": "weaving"},
    "tight_gale": {f"{_CONTROLLER}.range": 180.0, f"{_SIMULATOR}.wind": [-12.0, 0.0, 0.0]},
    "zigzag": {f"{_TARGET}.motion": "zigzag", f"{_TARGET}.drive_time": 20.0},
    "sensor_noise": {
        f"{_SIMULATOR}.velocity_noise": 0.3,
        f"{_SIMULATOR}.attitude_noise": math.radians(0.5),
        f"{_SIMULATOR}.airspeed_noise": 0.3,
    },
}
_LAGS = {f"lag_{share:g}": share for share in LAG_SHARES}
_GUSTY_LAGS = {f"gust_lag_{share:g}": share for share in GUSTY_LAG_SHARES}
_DELAYS = {f"delay_{delay}": 1e-3 * delay for delay in DELAYS}
MISMATCHES = (*_LAGS, *_MISTAKEN, *_GUSTY_LAGS, *_DELAYS, *SENSOR_FAULTS)


def mismatched(config: str, name: str, overrides: tuple[str, ...] = ()) -> Configuration:
    """The flight of a mismatch; the first one where there are :func:`variants`.

    Args:
        config: Name or file of the configuration.
        name: One of :data:`MISMATCHES`.
        overrides: ``SECTION.PARAMETER=VALUE`` each, also of the duration; the mismatch comes on
            top.

    Raises:
        ParameterError: There is no such mismatch, or as of :func:`load_configuration`.
    """
    if name not in MISMATCHES:
        raise ParameterError(f"mismatch is {name!r}, must be one of {', '.join(MISMATCHES)}")
    overrides = (f"mission.duration={DURATION:g}", *overrides)
    mistaken: dict[str, object] = dict(_MISTAKEN.get(name, {}))
    share = (_LAGS | _GUSTY_LAGS).get(name)
    if share is not None:
        truth = load_configuration(config, overrides, SCENARIO).simulator
        for channel in ("rate_lag", "dead_time"):
            mistaken[f"{_CONTROLLER}.{channel}"] = [
                share * time for time in getattr(truth, channel)
            ]
    if name == "second_order_roll":
        frequency, damping = ROLL
        turn, climb, gain = load_configuration(config, overrides, SCENARIO).simulator.rate_lag
        if turn > 0.0:  # else the controller knows no lag, as the paper's
            mistaken[f"{_CONTROLLER}.rate_lag"] = [2.0 * damping / frequency, climb, gain]
    if name in _GUSTY_LAGS:
        mistaken |= _MISTAKEN["gust_moderate"]
    fault = SENSOR_FAULTS.get(name)
    if fault is not None:
        mistaken |= fault.overrides
    told = [f"{parameter}={value}" for parameter, value in mistaken.items()]
    configuration = load_configuration(config, [*overrides, *told], SCENARIO)
    if fault is not None:
        return _changing(configuration, fault.changes(0, configuration.controller.altitude))
    if name not in _DELAYS:
        return configuration
    late = f"{_SIMULATOR}.command_delay={_DELAYS[name]:g}"
    return _changing(configuration, ((LATER, late),))


def _changing(configuration: Configuration, changes: Changes) -> Configuration:
    """With changes in flight, which come sooner in a shorter one."""
    share = min(configuration.mission.duration, DURATION) / DURATION
    sooner = tuple((share * time, change) for time, change in changes)
    return replace(configuration, changes=sooner)


def variants(configuration: Configuration, name: str) -> list[Configuration]:
    """All flights of a mismatch, of which the worst counts: seeds of gusts, periods of weaving.

    Args:
        configuration: As of :func:`mismatched`.
        name: Of the mismatch.
    """
    section, parameter, values = _SIMULATOR, "seed", list[float](SEEDS)
    if name in SENSOR_FAULTS and SENSOR_FAULTS[name].seeded:
        return [
            _changing(
                configuration.changed(section, {parameter: seed}),
                changes(seed, configuration.controller.altitude),
            )
            for seed, changes in ((seed, SENSOR_FAULTS[name].changes) for seed in SEEDS)
        ]
    if name == "weaving_target":
        section, parameter, values = _TARGET, "weave_period", list(WEAVING_PERIODS)
    elif not name.startswith("gust_"):
        return [configuration]
    return [configuration.changed(section, {parameter: value}) for value in values]


def settled_after(configuration: Configuration) -> float:
    """Time in [s] from which on a flight counts; of a shorter flight than usual, its share.

    Args:
        configuration: What is flown.
    """
    return SETTLED_AFTER / DURATION * min(configuration.mission.duration, DURATION)


def scenarios_in_order() -> list[str]:
    """Names of all scenarios that come with the package, from easy to hard."""
    names = scenario_names()
    return [*(name for name in ORDER if name in names), *(n for n in names if n not in ORDER)]
