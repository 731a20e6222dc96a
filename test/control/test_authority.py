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
"""Bank and force that the aircraft gives at most: found, flown by, and given up again."""

import math

import numpy as np
import pytest

from uav_tracking_mpc.control.authority import BANK, FORCE, Ceiling
from uav_tracking_mpc.dynamics.air import GRAVITY
from uav_tracking_mpc.dynamics.vehicle import followed
from uav_tracking_mpc.settings.configuration import load_configuration
from uav_tracking_mpc.simulation.closed_loop import ClosedLoop

TICK, TOLD, DELAY = 0.05, 0.8, 0.5  # s, rad, s


def ceilings(asked, most=lambda time: math.inf, gain=1.0, lag=DELAY, duration=60.0):
    """(time, ceiling) at each change, of a channel that gives what it is asked for up to a most."""
    ceiling, flown, changes = Ceiling(BANK), 0.0, []
    for tick in range(round(duration / TICK)):
        time = tick * TICK
        wanted = min(asked(time), ceiling.most + BANK.more)
        flown += followed(TICK, lag) * (min(gain * wanted, most(time)) - flown)
        if ceiling.see(time, wanted, (flown, flown), TOLD, DELAY):
            changes.append((time, ceiling.most))
    return changes


def swinging(time):
    return 0.4 + 0.3 * math.sin(time)


@pytest.mark.parametrize(
    ("asked", "most"),
    [(lambda _: 0.8, 0.5), (lambda _: 0.5, 0.17), (lambda time: 0.3 + 0.02 * time, 0.4)],
    ids=["all that was told", "no gain explains it", "more and more"],
)
def test_a_ceiling_is_found_within_seconds_of_being_missed(asked, most):
    (time, found), *others = ceilings(asked, lambda _: most, duration=30.0)
    missed = next(tick * TICK for tick in range(600) if asked(tick * TICK) > most + 0.05)
    assert found == pytest.approx(most, abs=0.02)
    assert time - missed < 12.0
    assert not others


@pytest.mark.parametrize("gain", [0.55, 0.7, 1.0, 1.5])
@pytest.mark.parametrize("lag", [0.1, 0.5, 1.5])
def test_neither_a_gain_nor_a_lag_is_a_ceiling(gain, lag):
    assert not ceilings(swinging, gain=gain, lag=lag)


@pytest.mark.parametrize("swing", [0.0, 0.1])
def test_a_gust_that_holds_the_wings_level_for_seconds_is_no_limit(swing):
    """Nor does one that swings them about a bank which is much less than is asked for."""
    ceiling, mean = Ceiling(BANK), 0.15 if swing else 0.0
    for tick in range(200):
        given = mean + swing * math.sin(2.0 * tick * TICK)
        assert not ceiling.see(tick * TICK, 0.5, (given, given), TOLD, DELAY)


def test_a_ceiling_that_was_found_too_low_ends_at_what_is_given():
    """What it rises by is asked for and not given: plans would count on it lap after lap."""
    changes = ceilings(lambda _: TOLD, lambda time: 0.235 if time < 20.0 else 0.262)
    assert [most for _, most in changes] == pytest.approx([0.235, 0.362, 0.262], abs=0.01)


def test_a_ceiling_that_is_no_more_is_given_up():
    changes = ceilings(lambda _: TOLD, lambda time: 0.2 if time < 20.0 else math.inf)
    assert changes[0][1] == pytest.approx(0.2, abs=0.02)
    assert changes[-1][1] == math.inf
    assert 20.0 < changes[-1][0] < 55.0


def test_after_a_gap_nothing_of_before_counts():
    ceiling = Ceiling(FORCE)
    for begin in (0.0, 10.0):
        for tick in range(70):  # two spans would be 80
            told = begin + tick * TICK, 3.0, (0.0, 0.0), 3.0, DELAY
            assert not ceiling.see(*told)


def flight(duration, *overrides, force=None):
    """Words of the events, and the log, from the orbit of ``small_uav`` on in its ``crosswind``.

    Args:
        force: Greatest thrust less drag over mass, by the time, in [m/s^2].
    """
    start = ["initial_position=[275.0, 0.0, 120.0]", "initial_heading=-1.5707963", *overrides]
    chosen = [f"uav_simulator.{each}" for each in start]
    loop = ClosedLoop(load_configuration("small_uav", chosen, "crosswind"))
    plant = loop.plant
    if force is not None:
        healthy = plant.inputs

        def failed():
            turn, climb, acceleration = healthy()
            weight = GRAVITY * math.sin(plant.state[4])
            return turn, climb, min(acceleration, force(plant.time) - weight)

        plant.inputs = failed
    words = []
    for _ in range(round(duration * loop.rate)):
        loop.tick()
        words += [event.words for event in loop.controller.events.take()]
    return words, loop.log(duration)


def test_a_bank_limit_that_nobody_told_is_flown_by():
    words, log = flight(90.0, "bank_max=0.26")  # 15 deg; the orbit needs 20 where the wind follows
    assert [each for each in words if "bank_max" in each] == [
        "the aircraft banks by 15 deg at most, less than bank_max"
    ]
    assert np.max(np.abs(log.error[log.time > 30.0, 0])) < 25.0  # 90 m without


def test_an_aircraft_whose_engine_has_failed_glides_at_its_least_airspeed_and_recovers():
    words, log = flight(75.0, force=lambda time: -0.9 if 5.0 < time < 35.0 else 5.0)
    told = [each for each in words if "force_max" in each]
    assert told == [
        "the aircraft gives -0.9 m/s^2 at most, less than force_max: does the engine run?"
    ]
    failed = (log.time > 5.0) & (log.time < 35.0)
    assert np.min(log.vehicle[:, 5]) > 13.0  # airspeed_min is 14; without, it falls to 10
    assert np.max(np.abs(log.error[failed, 0])) < 5.0
    assert log.vehicle[-1, 5] == pytest.approx(22.0, abs=0.5)
