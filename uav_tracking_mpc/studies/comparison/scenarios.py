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

"""What is compared, by name: laws, scenarios, and mismatches as changes of a scenario.

A mismatch is what the controller is not told: lag, delay, noise, biases, gusts, a target that is
hard to follow, a sensor that fails in flight. Names are in the help of commands: nothing is
imported here that takes long.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np

from uav_tracking_mpc.parameters.registry import names_of
from uav_tracking_mpc.parameters.specification import ParameterError
from uav_tracking_mpc.settings.configuration import (
    Configuration,
    load_configuration,
    scenario_names,
)
from uav_tracking_mpc.settings.simulator import SimulatorParameters
from uav_tracking_mpc.settings.tracking import PREDICTIVE

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


def scenarios_in_order() -> list[str]:
    """Names of all scenarios that come with the package, from easy to hard."""
    names = scenario_names()
    return [*(name for name in ORDER if name in names), *(n for n in names if n not in ORDER)]


SCENARIO = "crosswind"
DURATION, SETTLED_AFTER = 300.0, 90.0  # s, of a flight and until it counts
SEEDS = range(5)  # of gusts: the worst flight counts
ROLL = 3.0, 0.6  # rad/s and -, frequency and damping of a roll that is told as a lag
WEAVING_PERIODS = (4.0, 8.0, 12.0)  # s
MODERATE = 15.4  # m/s: W20
BEGIN, END = 120.0, 210.0  # s, of what fails in flight and recovers
STEP = 0.5  # s between changes of what changes all the time
TURN, WIND = 60.0, 8.0  # s, in which the wind turns by a right angle; m/s
SPIKE, SPIKES, JUMP, JUMPS = 10.0, 8.0, 8.0, 6.0  # m and s: of short and of lasting jumps
FROZEN, FLIPPED, OFFSET = 10.0, 0.5, 30.0  # s
HEIGHT_STEP, HEIGHT_STEPS = 3.0, 20.0  # m, s
EIGHT_LENGTH, EIGHT_WIDTH, EIGHT_POINTS = 70.0, 50.0, 60  # m, m, -
EIGHT_SPEED, EIGHT_NOISE = 5.2135, 2.0  # m/s, m: once round in 50 s
UNSEEN = 20.0  # s
CLIMB, DRIFT = 60.0, 0.1  # m, m/s^2
_SIMULATOR, _TARGET, _CONTROLLER = "uav_simulator", "target_publisher", "nmpc_controller"

Overrides = dict[str, object]  # by SECTION.PARAMETER
Changes = tuple[tuple[float, str], ...]  # times in [s] and SECTION.PARAMETER=VALUE from then on


def _simulator(**values: object) -> Overrides:
    return {f"{_SIMULATOR}.{name}": value for name, value in values.items()}


def _target(**values: object) -> Overrides:
    return {f"{_TARGET}.{name}": value for name, value in values.items()}


@dataclass(frozen=True)
class Mismatch:
    """What the controller is not told.

    Attributes:
        overrides: Parameters from the start.
        told: What the controller is told from the start, of what the aircraft has.
        changes: Changes in flight, of a seed and the orbit's altitude in [m].
        varied: Parameter in which flights differ, of which the worst counts.
        values: That it has in these flights; none for a single flight.
    """

    overrides: Overrides = field(default_factory=dict)
    told: Callable[[SimulatorParameters], Overrides] = lambda truth: {}
    changes: Callable[[int, float], Changes] | None = None
    varied: tuple[str, str] = (_SIMULATOR, "seed")
    values: Sequence[float] = ()


def _share(share: float) -> Callable[[SimulatorParameters], Overrides]:
    """So many times the lag and the dead time."""
    return lambda truth: {
        f"{_CONTROLLER}.{channel}": [share * time for time in getattr(truth, channel)]
        for channel in ("rate_lag", "dead_time")
    }


def _roll(truth: SimulatorParameters) -> Overrides:
    frequency, damping = ROLL
    turn, climb, gain = truth.rate_lag
    if turn == 0.0:  # the controller knows no lag, as the paper's
        return {}
    return {f"{_CONTROLLER}.rate_lag": [2.0 * damping / frequency, climb, gain]}


def _later(*changes: tuple[float, Overrides]) -> Callable[[int, float], Changes]:
    """Parameters from times on."""
    return lambda seed, height: tuple(
        (time, f"{key}={value}") for time, values in changes for key, value in values.items()
    )


def _fails(until: float = math.inf, **wrong: object) -> Callable[[int, float], Changes]:
    """Parameters of the simulator that are wrong from the begin on, until they are right again."""
    right = {each: getattr(SimulatorParameters(), each) for each in wrong}
    right |= {each: list(value) for each, value in right.items() if isinstance(value, tuple)}
    ended = [(until, _simulator(**right))] if math.isfinite(until) else []
    return _later((BEGIN, _simulator(**wrong)), *ended)


def _all_the_time(
    duration: float, change: Callable[[float], Overrides]
) -> list[tuple[float, Overrides]]:
    """What changes from the begin on, by the time since then."""
    return [(BEGIN + t, change(float(t))) for t in np.arange(0.0, duration + STEP, STEP)]


def _blocked(seed: int, height: float) -> Changes:
    return (
        (BEGIN, f"{_CONTROLLER}.altitude={height + CLIMB}"),
        *_fails(END, airspeed_fault="blocked")(seed, height),
        (END, f"{_CONTROLLER}.altitude={height}"),
    )


def _turned(t: float) -> Overrides:
    angle = math.pi / 2.0 * (1.0 + min(t / TURN, 1.0))
    return {
        f"{_SIMULATOR}.wind": f"[{WIND * math.cos(angle):.4f}, {WIND * math.sin(angle):.4f}, 0.0]"
    }


def _displaced(
    seed: int, height: float, size: float, period: float, lasting: Callable[[Any], float]
) -> Changes:
    """Positions off to random sides, from the begin to the end of the flight."""
    random = np.random.default_rng(seed)
    changes: list[tuple[float, str]] = []
    for time in np.arange(BEGIN, 300.0 - period, period):
        angle = random.uniform(-math.pi, math.pi)
        east, north = size * math.cos(angle), size * math.sin(angle)
        changes.append((time, f"{_SIMULATOR}.position_bias=[{east:.4f}, {north:.4f}, 0.0]"))
        if (length := lasting(random)) < period:
            changes.append((time + length, f"{_SIMULATOR}.position_bias=[0.0, 0.0, 0.0]"))
    return tuple(changes)


def _figure_of_eight() -> list[float]:
    angles = np.linspace(0.0, 2.0 * math.pi, EIGHT_POINTS, endpoint=False)
    east, north = 0.5 * EIGHT_LENGTH * np.sin(angles), 0.5 * EIGHT_WIDTH * np.sin(2.0 * angles)
    corners = np.column_stack([east, north, np.zeros_like(east)])
    return [float(each) for each in corners.round(3).ravel()]


_EIGHT = {"waypoints": _figure_of_eight(), "speed": EIGHT_SPEED, "noise": EIGHT_NOISE}
_UNSEEN = _later((BEGIN, _target(dropout=1.0)), (BEGIN + UNSEEN, _target(dropout=0.0)))
# Sensors that fail in flight and targets that are hard to follow.
SENSOR_FAULTS = {
    "airspeed_plus_3": Mismatch(changes=_fails(airspeed_bias=3.0, airspeed_fault="stuck")),
    "airspeed_at_26": Mismatch(_simulator(airspeed_bias=4.0, airspeed_fault="stuck")),
    "airspeed_stuck_gusts": Mismatch(
        _simulator(gust_intensity=MODERATE), changes=_fails(airspeed_fault="stuck"), values=SEEDS
    ),
    "airspeed_drift": Mismatch(
        changes=_later(
            *_all_the_time(END - BEGIN, lambda t: _simulator(airspeed_bias=f"{DRIFT * t:.3f}")),
            (END + STEP, _simulator(airspeed_bias=0.0)),
        )
    ),
    "airspeed_zero": Mismatch(changes=_fails(END, airspeed_bias=-50.0)),
    "airspeed_blocked": Mismatch(changes=_blocked),
    "airspeed_none": Mismatch(_simulator(airspeed_fault="silent")),
    "airspeed_lost": Mismatch(changes=_fails(airspeed_fault="silent")),
    "position_spikes": Mismatch(
        changes=partial(
            _displaced, size=SPIKE, period=SPIKES, lasting=lambda random: random.uniform(0.5, 1.5)
        ),
        values=SEEDS,
    ),
    "position_jumps": Mismatch(
        changes=partial(_displaced, size=JUMP, period=JUMPS, lasting=lambda random: JUMPS),
        values=SEEDS,
    ),
    "position_offset": Mismatch(changes=_fails(BEGIN + OFFSET, position_bias=[JUMP, 0.0, 0.0])),
    "height_steps": Mismatch(
        changes=_later(
            *(
                (time, _simulator(position_bias=[0.0, 0.0, HEIGHT_STEP * (1 - k % 2)]))
                for k, time in enumerate(np.arange(BEGIN, 300.0 - HEIGHT_STEPS, HEIGHT_STEPS))
            )
        )
    ),
    "position_frozen": Mismatch(changes=_fails(BEGIN + FROZEN, position_fault="frozen")),
    "position_silent": Mismatch(changes=_fails(BEGIN + FROZEN, position_fault="silent")),
    "heading_30": Mismatch(changes=_fails(heading_bias=math.radians(30.0))),
    "velocity_flip": Mismatch(changes=_fails(BEGIN + FLIPPED, velocity_gain=-1.0)),
    "wind_turns": Mismatch(changes=_later(*_all_the_time(TURN, _turned))),
    "figure8_noise": Mismatch(_target(motion="waypoints", **_EIGHT)),
    "stop_and_go_8": Mismatch(
        _target(motion="stop_and_go", speed=8.0, drive_time=12.0, stand_time=18.0)
    ),
    "zigzag_10": Mismatch(_target(motion="zigzag", drive_time=10.0)),
    "dropout_straight": Mismatch(changes=_UNSEEN),
    "dropout_circling": Mismatch(_target(motion="circle", radius=80.0, speed=5.0), changes=_UNSEEN),
}
MISMATCHES = {
    # Shares of lag and dead time that the controller is told.
    **{
        f"lag_{share:g}": Mismatch(told=_share(share))
        for share in (0.0, 0.25, 0.5, 0.75, 1.5, 2.0, 3.0)
    },
    "late_0.1": Mismatch(_simulator(state_delay=0.1, state_stamp_true=False)),
    "late_0.3": Mismatch(_simulator(state_delay=0.3, state_stamp_true=False)),
    "stamped_0.3": Mismatch(_simulator(state_delay=0.3)),
    **{f"noise_{noise:g}": Mismatch(_target(noise=noise, rate=5.0)) for noise in (0.5, 2.0, 5.0)},
    "wind_bias_2": Mismatch(_simulator(velocity_bias=[2.0, 0.0, 0.0])),
    "heading_bias_5": Mismatch(_simulator(heading_bias=math.radians(5.0))),
    "airspeed_bias_2": Mismatch(_simulator(airspeed_bias=2.0)),
    "turn_rate_bias_2": Mismatch(_simulator(turn_rate_bias=math.radians(2.0))),
    **{
        f"gust_{name}": Mismatch(_simulator(gust_intensity=w20), values=SEEDS)
        for name, w20 in (("light", 7.7), ("moderate", MODERATE), ("severe", 23.2))
    },
    "second_order_roll": Mismatch(
        _simulator(roll_frequency=ROLL[0], roll_damping=ROLL[1]), told=_roll
    ),
    "bank_15": Mismatch(_simulator(bank_max=math.radians(15.0))),
    "weaving_target": Mismatch(
        _target(motion="weaving"), varied=(_TARGET, "weave_period"), values=WEAVING_PERIODS
    ),
    "tight_gale": Mismatch({f"{_CONTROLLER}.range": 180.0, **_simulator(wind=[-12.0, 0.0, 0.0])}),
    "zigzag": Mismatch(_target(motion="zigzag", drive_time=20.0)),
    "sensor_noise": Mismatch(
        _simulator(velocity_noise=0.3, attitude_noise=math.radians(0.5), airspeed_noise=0.3)
    ),
    **{
        f"gust_lag_{share:g}": Mismatch(
            _simulator(gust_intensity=MODERATE), _share(share), values=SEEDS
        )
        for share in (0.0, 0.25, 0.5, 2.0, 3.0)
    },
    **{
        f"delay_{delay}": Mismatch(
            changes=_later((BEGIN, _simulator(command_delay=f"{1e-3 * delay:g}")))
        )
        for delay in (100, 200, 400)
    },
    **SENSOR_FAULTS,
}


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
    mismatch, overrides = MISMATCHES[name], (f"mission.duration={DURATION:g}", *overrides)
    truth = load_configuration(config, overrides, SCENARIO).simulator
    mistaken = mismatch.overrides | mismatch.told(truth)
    told = [f"{parameter}={value}" for parameter, value in mistaken.items()]
    return _changing(load_configuration(config, [*overrides, *told], SCENARIO), mismatch)


def _changing(configuration: Configuration, mismatch: Mismatch) -> Configuration:
    """With the changes in flight, which come sooner in a shorter one."""
    if mismatch.changes is None:
        return configuration
    share = min(configuration.mission.duration, DURATION) / DURATION
    changes = mismatch.changes(configuration.simulator.seed, configuration.controller.altitude)
    return replace(configuration, changes=tuple((share * time, each) for time, each in changes))


def variants(configuration: Configuration, name: str) -> list[Configuration]:
    """All flights of a mismatch, of which the worst counts: seeds of gusts, periods of weaving.

    Args:
        configuration: As of :func:`mismatched`.
        name: Of the mismatch; a scenario has one flight.
    """
    mismatch = MISMATCHES.get(name, Mismatch())
    section, parameter = mismatch.varied
    several = [configuration.changed(section, {parameter: each}) for each in mismatch.values]
    return [_changing(each, mismatch) for each in several] or [configuration]


def settled_after(configuration: Configuration) -> float:
    """Time in [s] from which on a flight counts; of a shorter flight than usual, its share.

    Args:
        configuration: What is flown.
    """
    return SETTLED_AFTER / DURATION * min(configuration.mission.duration, DURATION)
