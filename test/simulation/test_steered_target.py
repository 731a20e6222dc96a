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

"""A steered target never jumps, goes where it is sent, and refuses what it does not know."""

from dataclasses import replace

import numpy as np
import pytest

from uav_tracking_mpc.parameters.specification import ParameterError
from uav_tracking_mpc.settings.simulator import TargetParameters
from uav_tracking_mpc.simulation.motions import TargetMotion, motion_of
from uav_tracking_mpc.simulation.plants import SimulationError
from uav_tracking_mpc.simulation.steered_target import GOING_SPEED, SteeredTarget, TargetSensor

LINE = TargetParameters(motion="line", position=(10.0, -20.0, 3.0), speed=5.0, heading=0.7)
CORNERS = (0.0, 0.0, 0.0, 30.0, 0.0, 0.0, 30.0, 40.0, 0.0)
KINDS = ("stationary", "line", "circle", "waypoints", "stop_and_go", "zigzag")


@pytest.mark.parametrize("kind", [*KINDS, "jump"])
@pytest.mark.parametrize("time", [0.0, 33.3, 99.9])
def test_left_alone_it_is_its_motion(kind, time):
    parameters = replace(LINE, motion=kind)
    target, motion = SteeredTarget(parameters), motion_of(parameters)
    np.testing.assert_array_equal(target.position(time), motion.position(time))
    np.testing.assert_array_equal(target.velocity(time), motion.velocity(time))


class Stopping(TargetMotion):
    """Answers what it is told to answer once it has moved for 20 s."""

    name = "stopping"

    def position(self, time):
        return np.zeros(3) if time < 20.0 else self.later()

    def velocity(self, time):
        return np.zeros(3)

    def later(self):
        raise RuntimeError("boom")


class Vanishing(Stopping):
    name = "vanishing"

    def later(self):
        return np.full(3, np.nan)


@pytest.mark.parametrize(
    ("motion", "words"),
    [
        (Stopping, "at 20.5 s the target motion '.*:Stopping' failed: RuntimeError: boom"),
        (Vanishing, "at 20.5 s the position of the target motion '.*:Vanishing' is .*nan"),
    ],
)
def test_a_motion_that_fails_on_its_way_is_named(motion, words):
    target = SteeredTarget(replace(LINE, motion=f"{__file__}:{motion.__name__}"))
    np.testing.assert_array_equal(target.position(19.5), np.zeros(3))
    with pytest.raises(SimulationError, match=words):
        target.position(20.5)


@pytest.mark.parametrize("after", KINDS)
@pytest.mark.parametrize("before", KINDS)
def test_from_one_motion_to_another_it_never_jumps(before, after):
    first = replace(LINE, motion=before, waypoints=CORNERS, drive_time=2.0)
    target, speed = SteeredTarget(first), 7.0
    samples = [target.position(time) for time in np.arange(12.0, 13.0, 0.05)]
    target.change(13.0, replace(first, motion=after, speed=speed, radius=12.0))
    samples += [target.position(time) for time in np.arange(13.0, 60.0, 0.05)]
    steps = np.linalg.norm(np.diff(samples, axis=0), axis=1)
    assert steps.max() <= 0.05 * speed + 1e-9
    ahead = (target.position(50.0 + 1e-5) - target.position(50.0)) / 1e-5
    np.testing.assert_allclose(target.velocity(50.0), ahead, atol=1e-3)


def test_a_circle_goes_on_round_its_centre_when_its_speed_changes():
    circle = replace(LINE, motion="circle", radius=40.0)
    target = SteeredTarget(circle)
    before = target.position(20.0)
    target.change(20.0, replace(circle, speed=8.0))
    np.testing.assert_allclose(target.position(20.0), before, atol=1e-9)
    assert np.linalg.norm(target.velocity(20.0)) == pytest.approx(8.0)
    assert np.linalg.norm(target.position(55.0) - circle.position) == pytest.approx(40.0)


def test_waypoints_go_on_along_their_path_when_their_speed_changes():
    path = replace(LINE, motion="waypoints", waypoints=CORNERS)
    target = SteeredTarget(path)
    target.change(10.0, replace(path, speed=10.0))  # half way up the second chord, at 20 m of 40
    driven = [target.position(time) for time in (12.0, 17.0, 20.0)]
    np.testing.assert_allclose(driven, [[30, 40, 0], [0, 0, 0], [30, 0, 0]], atol=1e-9)


def test_waypoints_there_and_back_keep_their_direction():
    path = replace(LINE, motion="waypoints", waypoints=(0.0, 0.0, 0.0, 100.0, 0.0, 0.0))
    target = SteeredTarget(path)
    target.change(25.0, replace(path, speed=10.0))  # on the way back, at 75 m
    np.testing.assert_allclose(target.velocity(25.0), [-10.0, 0.0, 0.0])


def test_a_changed_position_is_driven_to():
    target = SteeredTarget(replace(LINE, motion="stationary"))
    target.change(4.0, replace(LINE, motion="stationary", position=(10.0, 0.0, 3.0)))
    np.testing.assert_allclose(target.velocity(4.0), [0.0, 5.0, 0.0])
    np.testing.assert_allclose(target.heading_for(7.9), [10.0, 0.0, 3.0])
    np.testing.assert_allclose(target.position(8.0), [10.0, 0.0, 3.0])
    assert target.heading_for(8.0) is None


@pytest.mark.parametrize(("speed", "flown"), [(4.0, 4.0), (0.0, GOING_SPEED)])
def test_it_goes_to_a_goal_and_stands_there(speed, flown):
    target = SteeredTarget(replace(LINE, speed=speed))
    start = target.position(2.0)
    goal = start + np.array([0.0, 30.0, 40.0])
    target.go_to(2.0, goal)
    assert np.linalg.norm(target.velocity(2.1)) == pytest.approx(flown)
    np.testing.assert_allclose(target.position(2.0 + 25.0 / flown), 0.5 * (start + goal))
    target.go_to(600.0, goal)  # where it is already
    for time in (2.0 + 50.0 / flown, 600.0):
        np.testing.assert_allclose(target.position(time), goal)
        np.testing.assert_array_equal(target.velocity(time), np.zeros(3))
    assert (target.parameters.motion, target.heading_for(600.0)) == ("stationary", None)


def test_on_its_way_to_a_goal_it_goes_on_there_whatever_else_changes():
    target = SteeredTarget(replace(LINE, motion="stationary", position=(0.0, 0.0, 0.0)))
    target.go_to(0.0, (100.0, 0.0, 0.0))
    target.change(5.0, replace(target.parameters, speed=10.0))
    np.testing.assert_allclose(target.position(60.0), [100.0, 0.0, 0.0])


def test_before_a_change_it_stands_where_that_was():
    """Time that goes back finds no motion of before."""
    target = SteeredTarget(LINE)
    target.go_to(10.0, (0.0, 0.0, 0.0))
    np.testing.assert_array_equal(target.position(3.0), target.position(10.0))


@pytest.mark.parametrize(
    ("values", "words"),
    [
        (
            {"motion": "waltz"},
            "circle, jump, line, stationary, stop_and_go, waypoints, weaving, zigzag",
        ),
        ({"seed": 4, "motion": "circle"}, "'seed' is 4, must stay 0 while the target moves"),
        ({"motion": f"{__file__}:Broken"}, "which failed: no wheels"),
        ({"motion": f"{__file__}:Flat"}, r"whose position is \[0\. 0\.\], must be three finite"),
        ({"motion": f"{__file__}:Nowhere"}, "whose velocity is .*nan.*, must be three finite"),
    ],
)
def test_what_it_does_not_know_is_refused_and_nothing_changes(values, words):
    target = SteeredTarget(LINE)
    before = target.position(5.0)
    with pytest.raises(ParameterError, match=words):
        target.change(5.0, replace(LINE, **values))
    assert target.parameters is LINE
    np.testing.assert_array_equal(target.position(5.0), before)


class Broken(type(motion_of(LINE))):
    """A motion that cannot be made."""

    name = "broken"

    def __init__(self, parameters):
        raise RuntimeError("no wheels")


class Flat(type(motion_of(LINE))):
    """A motion without a height."""

    name = "flat"

    def position(self, time):
        return np.zeros(2)


class Nowhere(type(motion_of(LINE))):
    """A motion without a velocity."""

    name = "nowhere"

    def velocity(self, time):
        return np.full(3, np.nan)


def test_noise_alone_does_not_touch_the_motion():
    target = SteeredTarget(replace(LINE, motion="stop_and_go"))
    before = target.position(43.0)
    target.change(30.0, replace(LINE, motion="stop_and_go", noise=3.0, dropout=0.5))
    np.testing.assert_array_equal(target.position(43.0), before)


MOVING = {"motion": "line", "speed": 5.0}


def fly(parameters, count=200, step=0.1):
    """(time delivered, time measured, position) of every delivery."""
    sensor, heard = TargetSensor(parameters, motion_of(parameters)), []
    for k in range(count):
        sensor.measure(k * step)
        heard += [(k * step, *delivery) for delivery in sensor.delivered(k * step)]
    return heard


@pytest.mark.parametrize(("delay", "count"), [(0.0, 200), (0.35, 196)])
def test_without_noise_it_is_the_truth_as_late_as_told(delay, count):
    parameters = TargetParameters(delay=delay, **MOVING)
    heard = fly(parameters)
    assert len(heard) == count
    for now, measured, position in heard:
        assert delay - 1e-8 <= now - measured < delay + 0.1  # the next look after the delay
        np.testing.assert_array_equal(position, motion_of(parameters).position(measured))


def test_noise_is_as_large_as_told_and_reproducible():
    parameters = TargetParameters(noise=3.0, seed=7)
    flights = [[position for _, _, position in fly(parameters, 4000)] for _ in range(2)]
    np.testing.assert_allclose(np.std(flights[0], axis=0), 3.0, rtol=0.05)
    np.testing.assert_array_equal(*flights)


def test_dropouts_are_as_frequent_as_told_and_leave_the_noise_of_the_others():
    whole = {t: p for _, t, p in fly(TargetParameters(noise=1.0), 4000)}
    some = {t: p for _, t, p in fly(TargetParameters(noise=1.0, dropout=0.3), 4000)}
    assert len(some) == pytest.approx(0.7 * 4000, rel=0.05)
    for time, position in some.items():
        np.testing.assert_array_equal(position, whole[time])
    assert not fly(TargetParameters(dropout=1.0))


def test_after_the_clock_went_back_nothing_of_the_future_is_delivered():
    parameters = TargetParameters(delay=1.0)
    sensor = TargetSensor(parameters, motion_of(parameters))
    sensor.measure(100.0)
    sensor.measure(2.0)
    assert [time for time, _ in sensor.delivered(200.0)] == [2.0]


def test_after_the_clock_went_back_a_motion_that_was_taken_up_goes_on():
    """From where it was: its own time has not gone back."""
    target = SteeredTarget(TargetParameters())
    target.change(100.0, replace(target.parameters, motion="line", speed=5.0))
    place = target.position(110.0)
    target.go_back(20.0, 110.0)
    np.testing.assert_allclose(target.position(20.0), place)
    np.testing.assert_allclose(target.position(21.0), place + target.velocity(21.0))
    assert np.linalg.norm(target.velocity(21.0)) == 5.0
