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

import sys
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from uav_tracking_mpc.estimation.target_filter import TargetFilter
from uav_tracking_mpc.estimation.target_track import FORGOTTEN, STRAIGHT_TIME, TURN


def fed(times, path, noise=0.0, agility=0.5, seed=0, dropouts=0.0):
    random = np.random.default_rng(seed)
    target = TargetFilter(max(noise, 0.1), agility)
    for time in times:
        if random.random() >= dropouts:
            target.update(time, path(time) + noise * random.standard_normal(3))
    return target


def ahead(target, lead):
    """Position, velocity and acceleration a time after the newest position, as it moves then."""
    track = target.track
    motion = TURN(track.state.ravel(), track.variance(2), track.turn_rate, lead)
    return motion.full().reshape(3, 3)


def circle(time):
    """R = 200 m at 5 m/s."""
    angle = 5.0 * time / 200.0
    return np.array([200.0 * np.cos(angle), 200.0 * np.sin(angle), 0.0])


def straight(time):
    return np.array([5.0 * time, -2.0 * time, 0.0])


def stop_and_go(time):
    """Runs 20 s at 6 m/s, stands 10 s, a second to stop and to go."""
    whole, part = divmod(time, 30.0)
    speed = np.interp(np.linspace(0.0, part, 400), [0, 1, 20, 21, 30], [0, 6, 6, 0, 0])
    return np.array([whole * 120.0 + np.mean(speed) * part, 0.0, 0.0])


def test_a_target_that_stands_is_where_it_was_measured():
    target = fed(np.arange(0, 5, 0.1), lambda t: np.array([3.0, -4.0, 1.0]))
    still = [0.0, 0.0, 0.0]
    np.testing.assert_allclose(target.motion(10.0), [[3.0, -4.0, 1.0], still, still], atol=1e-9)


def test_a_straight_run_is_learned_and_predicted():
    position, velocity, _ = fed(np.arange(0, 20, 0.2), straight).motion(22.0)
    np.testing.assert_allclose(velocity, [5.0, -2.0, 0.0], atol=0.02)
    np.testing.assert_allclose(position, straight(22.0), atol=0.1)


def test_irregular_times_do_no_harm():
    times = np.cumsum(np.random.default_rng(3).uniform(0.02, 1.5, 80))
    velocity = fed(times, lambda t: np.array([4.0 * t, 0.0, 0.0])).motion(times[-1])[1]
    np.testing.assert_allclose(velocity, [4.0, 0.0, 0.0], atol=0.05)


def test_noise_is_reduced_and_the_deviation_says_by_how_much():
    """3 m of noise at 5 Hz, a tenth of it lost, on a target that stands."""
    standing = [
        fed(np.arange(0, 40, 0.2), lambda t: np.zeros(3), 3.0, 0.05, seed, 0.1)
        for seed in range(20)
    ]
    error = np.std([target.motion(40.0)[0] for target in standing])
    assert error < 1.5
    assert error < 1.5 * np.mean([target.track.position_std(40.0) for target in standing])


def test_a_circle_is_predicted_along_the_turn():
    """10 s ahead a tangent would miss by 6 m."""
    target = fed(np.arange(0, 60, 0.1), circle)
    times = 59.9 + np.linspace(0.0, 10.0, 21)
    motions = [ahead(target, time - target.time) for time in times]
    positions, velocities, accelerations = np.swapaxes(motions, 0, 1)
    expected = np.array([circle(time) for time in times])
    np.testing.assert_allclose(positions, expected, atol=1.5)
    np.testing.assert_allclose(np.linalg.norm(velocities, axis=1), 5.0, atol=0.1)
    np.testing.assert_allclose(np.linalg.norm(accelerations, axis=1), 5.0**2 / 200.0, atol=0.03)


@pytest.mark.parametrize(
    ("path", "bound"),
    [(circle, 7.0), (straight, 6.5), (stop_and_go, 21.0)],
    ids=["circle", "straight", "stop_and_go"],
)
def test_noisy_targets_are_predicted_5_s_ahead(path, bound):
    """RMS error with 3 m of noise at 5 Hz and dropouts; a stop can only be told afterwards."""
    random, target, errors = np.random.default_rng(0), TargetFilter(3.0, 0.2), []
    for time in np.arange(0.0, 60.0, 0.2):
        if random.random() < 0.1:
            continue
        target.update(time, path(time) + 3.0 * random.standard_normal(3))
        if time > 20.0:
            errors.append(np.linalg.norm(ahead(target, 5.0)[0] - path(time + 5.0)))
    assert np.sqrt(np.mean(np.square(errors))) < bound


def test_a_target_stopping_and_going_is_followed():
    target = TargetFilter(0.1, 0.5)
    errors = []
    for time in np.arange(0.0, 60.0, 0.1):
        target.update(time, stop_and_go(time))
        errors.append(np.linalg.norm(target.motion(time)[0] - stop_and_go(time)))
    assert max(errors) < 3.0
    assert np.sqrt(np.mean(np.square(errors))) < 0.3


def test_outliers_are_left_out_and_counted():
    target = TargetFilter(1.0, 0.5)
    random = np.random.default_rng(0)
    for k, time in enumerate(np.arange(0.0, 30.0, 0.2)):
        position = straight(time) + 0.3 * random.standard_normal(3)
        if k % 10 == 9:
            assert not target.update(time, position + random.uniform(50, 500, 3))
        else:
            assert target.update(time, position)
    assert (target.rejected, target.jumps) == (15, 0)
    np.testing.assert_allclose(target.motion(30.0)[0], straight(30.0), atol=1.0)


def test_outliers_in_a_row_that_do_not_agree_are_left_out():
    target = fed(np.arange(0, 10, 0.2), straight)
    for k, time in enumerate((10.0, 10.2, 10.4, 10.6, 10.8)):
        assert not target.update(time, [1000.0 * (-1) ** k, 300.0 * k, 0.0])
    assert target.jumps == 0
    np.testing.assert_allclose(target.motion(11.0)[0], straight(11.0), atol=0.5)


def test_a_jump_is_followed_at_the_third_position():
    target = fed(np.arange(0, 10, 0.1), straight)
    jump = np.array([200.0, 100.0, 0.0])
    taken = [target.update(time, straight(time) + jump) for time in (10.0, 10.1, 10.2, 10.3)]
    assert taken == [False, False, True, True]
    assert (target.rejected, target.jumps, target.time) == (2, 1, 10.3)
    np.testing.assert_allclose(target.motion(10.3)[0], straight(10.3) + jump, atol=0.3)


def test_a_dropout_is_bridged_and_then_the_velocity_fades():
    target = fed(np.arange(0, 20, 0.1), straight)
    np.testing.assert_allclose(target.motion(24.0)[0], straight(24.0), atol=0.1)
    position, velocity, _ = target.motion(140.0)
    np.testing.assert_allclose(velocity, 0.0, atol=1e-3)
    held = 19.9 + STRAIGHT_TIME
    np.testing.assert_allclose(target.motion(held)[0], straight(held), atol=1.0)
    assert np.linalg.norm(position - straight(held)) < 11.0 * np.linalg.norm(straight(1.0))
    early, later, latest = (target.track.position_std(time) for time in (20.0, 24.0, 140.0))
    assert early < later < latest


def test_a_target_that_turned_before_it_hid_runs_on_for_a_few_seconds_alone():
    def circle(time):
        angle = 0.25 * np.asarray(time)
        return 20.0 * np.array([np.cos(angle), np.sin(angle), 0.0])

    target = fed(np.arange(0, 20, 0.1), circle)
    assert np.linalg.norm(target.motion(60.0)[1]) < 0.05 * 5.0


def test_after_a_dropout_the_target_is_believed_where_it_is():
    target = fed(np.arange(0, 20, 0.1), straight)
    assert target.update(40.0, straight(40.0) + np.array([10.0, 5.0, 0.0]))
    assert target.update(20.0 + 2 * FORGOTTEN, [1e6, 0.0, 0.0])
    np.testing.assert_array_equal(target.motion(target.time)[0], [1e6, 0.0, 0.0])


def test_late_positions_are_left_out_and_counted():
    target = fed([0.0, 1.0, 2.0], straight)
    before = target.motion(3.0)
    assert not target.update(1.5, [100.0, 0.0, 0.0])
    assert not target.update(2.0, [100.0, 0.0, 0.0])
    assert target.late == 2
    np.testing.assert_array_equal(target.motion(3.0), before)


@pytest.mark.parametrize("position", [[np.nan, 0, 0], [0, 0], [np.inf, 0, 0], [[0, 0, 0]]])
def test_what_is_no_position_is_refused_and_changes_nothing(position):
    target = fed([0.0, 1.0], lambda t: np.zeros(3))
    before = target.motion(2.0)
    with pytest.raises(ValueError, match="three finite numbers"):
        target.update(1.5, position)
    with pytest.raises(ValueError, match="must be finite"):
        target.update(np.nan, [0.0, 0.0, 0.0])
    np.testing.assert_array_equal(target.motion(2.0), before)


def test_nothing_measured_is_said():
    target = fed([0.0], straight)
    target.reset()
    assert target.time is None
    with pytest.raises(ValueError, match="no target position"):
        target.motion(0.0)


@given(
    st.lists(
        st.tuples(st.floats(-1.0, 400.0), st.lists(st.floats(-1e7, 1e7), min_size=3, max_size=3)),
        min_size=1,
        max_size=30,
    ),
    st.sampled_from([1e-3, 3.0, 1e3]),
    st.sampled_from([1e-3, 0.5, 100.0]),
    st.floats(-1e4, 1e4),
)
def test_whatever_is_measured_estimates_are_finite(steps, noise, agility, lead):
    target, time = TargetFilter(noise, agility), 0.0
    for elapsed, position in steps:
        time += elapsed
        target.update(time, position)
        assert np.all(np.isfinite(target.motion(time + lead)))
        assert 0.0 < target.track.position_std(time + lead) < np.inf


def test_a_velocity_is_used_at_once():
    knows, learns = TargetFilter(1.0, 0.5), TargetFilter(1.0, 0.5)
    covariance = np.diag([1.0] * 3 + [0.01] * 3)
    for k in range(2):
        place = np.array([5.0 * k * 0.2, 0.0, 0.0])
        knows.update(0.2 * k, place, [5.0, 0.0, 0.0], covariance)
        learns.update(0.2 * k, place)
    np.testing.assert_allclose(knows.motion(0.2)[1], [5.0, 0.0, 0.0], atol=0.2)
    assert learns.motion(0.2)[1][0] < 4.5


def test_the_covariance_that_comes_with_a_position_counts():
    """Of a target that stands: precise positions weigh as much as their variance says."""
    target, random, errors = TargetFilter(1.0, 0.5), np.random.default_rng(0), []
    for k in range(400):
        sigma = 0.3 if k % 4 == 0 else 6.0
        covariance = np.diag([sigma**2, 0.5 * sigma**2, 1e6])  # a planar tracker
        position = sigma * random.standard_normal(3) * [1.0, 0.5, 0.0]
        target.update(0.2 * k, position, covariance=covariance)
        if k > 100:
            errors.append(target.motion(0.2 * k)[0])
    assert np.std(errors) < 0.1  # 0.3 m over the root of a hundred is 0.03 m, of 6 m it is 0.6 m
    assert target.noise == pytest.approx(6.0, rel=0.2)


def test_a_covariance_that_the_positions_belie_is_corrected():
    """Told 0.1 m by the tracker, true 3 m: no position of a good track is left out for long."""
    target, random = TargetFilter(0.1, 0.5), np.random.default_rng(1)
    for time in np.arange(0.0, 60.0, 0.2):
        position = straight(time) + 3.0 * random.standard_normal(3)
        target.update(time, position, covariance=0.01 * np.eye(3))
    assert target.rejected < 5 and target.noise == pytest.approx(3.0, rel=0.3)
    np.testing.assert_allclose(target.motion(60.0)[1], [5.0, -2.0, 0.0], atol=0.3)


def test_a_block_of_zeros_is_no_covariance():
    told, own = TargetFilter(2.0, 0.5), TargetFilter(2.0, 0.5)
    for k, x in enumerate((0.0, 3.0, -4.0, 6.0)):
        blocks = np.diag([0.0] * 3 + [1.0] * 3)  # that of the velocity is the filter's own
        told.update(0.2 * k, [x, 0.0, 0.0], [5.0, 0.0, 0.0], blocks)
        own.update(0.2 * k, [x, 0.0, 0.0], [5.0, 0.0, 0.0])
    np.testing.assert_array_equal(told.motion(0.7)[0], own.motion(0.7)[0])


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("rate", [5.0, 10.0])
@pytest.mark.parametrize("true", [0.5, 5.0, 20.0])
def test_noise_told_far_too_small_does_not_leave_the_track(true, rate, seed):
    """Told 0.1 m. Once the noise is found hardly one position in a hundred is left out."""
    target, random = TargetFilter(0.1, 0.5), np.random.default_rng(seed)
    for k in range(round(60.0 * rate)):
        time = k / rate
        target.update(time, straight(time) + true * random.standard_normal(3))
        assert target.rejected <= 8 + 0.02 * k
    assert target.jumps <= 1
    assert target.noise == pytest.approx(true, rel=0.35)
    assert np.linalg.norm(target.motion(time)[0] - straight(time)) < true
    assert target.agility < 0.2


def test_noise_told_far_too_large_is_no_lag():
    """Told 10 m, true nothing: a turn on the spot is followed at once."""
    target = TargetFilter(10.0, 0.01)
    for k in range(304):
        time = 0.1 * k
        target.update(time, [5.0 * min(time, 30.0), 5.0 * max(0.0, time - 30.0), 0.0])
    assert target.noise < 0.01
    np.testing.assert_allclose(target.motion(time)[1], [0.0, 5.0, 0.0], atol=0.1)


def test_noise_that_grows_in_flight_is_found():
    target, random = TargetFilter(0.1, 0.5), np.random.default_rng(0)
    for k in range(600):
        sigma = 0.1 if k < 300 else 4.0
        target.update(0.2 * k, straight(0.2 * k) + sigma * random.standard_normal(3))
    assert target.noise == pytest.approx(4.0, rel=0.3)
    assert np.linalg.norm(target.motion(120.0)[0] - straight(120.0)) < 4.0


@pytest.mark.parametrize("level", [0.0, 0.5])
def test_heights_that_scatter_much_more_than_places_spoil_neither(level):
    """Of a target that drives uphill; noise of 5 m of its height alone."""
    random, target = np.random.default_rng(8), TargetFilter(0.1, 0.5)
    worst_place = worst_height = worst_climb = 0.0
    for time in np.arange(0.0, 120.0, 0.1):
        true = np.add(straight(time), [0.0, 0.0, 0.3 * time])
        target.update(time, true + random.standard_normal(3) * [level, level, 5.0])
        if time > 30.0:
            position, velocity, _ = target.motion(time)
            error = position - true
            worst_place = max(worst_place, np.abs(error[:2]).max())
            worst_height = max(worst_height, abs(error[2]))
            worst_climb = max(worst_climb, abs(velocity[2] - 0.3))
    assert worst_place < 0.01 + 2.0 * level
    assert worst_height < 5.0  # one deviation
    assert worst_climb < 0.5


@pytest.mark.parametrize("deviations", [[5.0, 0.3, 0.3], [0.3, 5.0, 0.3], [2.5, 2.5, 0.2]])
@pytest.mark.parametrize("told", [False, True])
def test_noise_that_is_far_greater_on_one_axis_is_no_turn(deviations, told):
    """One number for all axes is too small for it: velocities were 1.3 to 3.7 m/s off (RMS)."""
    random, target = np.random.default_rng(3), TargetFilter(0.5, 0.5)
    covariance, errors = np.diag(np.square(deviations)) if told else None, []
    for time in np.arange(0.0, 150.0, 0.1):
        position = straight(time) + deviations * random.standard_normal(3)
        target.update(time, position, covariance=covariance)
        if time > 30.0:
            errors.append(target.motion(time)[1] - straight(1.0))
    assert np.sqrt(np.mean(np.square(errors))) < 0.1
    assert target.jumps == 0


@pytest.mark.parametrize("interval", [0.1, 1.0])
def test_a_target_that_climbs_and_sinks_does_not_scatter(interval):
    """As a drone on a straight way does, measured without noise."""
    target, worst = TargetFilter(0.1, 0.5), 0.0
    for time in np.arange(0.0, 120.0, interval):
        true = np.add(straight(time), [0.0, 0.0, 10.0 * np.sin(0.3 * time)])
        target.update(time, true)
        if time > 30.0:
            worst = max(worst, abs(target.motion(time)[0][2] - true[2]))
    assert worst < 0.5


def test_heavy_tails_are_no_turns():
    """Student's t of 2 degrees of freedom, whose variance is infinite."""
    target, random, errors = TargetFilter(0.1, 0.5), np.random.default_rng(0), []
    for k in range(600):
        target.update(0.2 * k, straight(0.2 * k) + 0.5 * random.standard_t(2, 3))
        if k > 200:
            errors.append(np.linalg.norm(target.motion(0.2 * k)[1] - [5.0, -2.0, 0.0]))
    assert np.quantile(errors, 0.95) < 0.5


def test_an_array_that_is_filled_anew_with_each_position_is_no_old_one():
    target, position = TargetFilter(0.1, 0.5), np.zeros(3)
    for time in np.arange(0.0, 10.0, 0.1):
        position[:] = straight(time)
        assert target.update(time, position)


def test_an_old_position_that_is_sent_again_is_late():
    """Measured at 5 Hz, sent at 20 Hz, of a target that drives."""
    target = TargetFilter(0.1, 0.5)
    for k in range(200):
        target.update(0.05 * k, straight(0.2 * (k // 4)))
    assert target.late > 140
    np.testing.assert_allclose(target.motion(10.0)[1], [5.0, -2.0, 0.0], atol=0.01)


def test_a_target_that_stops_on_the_spot_is_seen_to_stand():
    target = TargetFilter(0.1, 0.5)
    for k in range(120):
        target.update(0.1 * k, straight(min(0.1 * k, 10.0)))
    np.testing.assert_allclose(target.motion(12.0)[1], 0.0, atol=0.1)
    assert target.jumps == 0


@pytest.mark.parametrize("speed", [5.0, 30.0, 60.0])
@pytest.mark.parametrize("rate", [1.0, 10.0])
def test_a_fast_target_is_caught(speed, rate):
    target = TargetFilter(0.1, 0.5)
    for k in range(12):
        target.update(k / rate, [speed * k / rate, 0.0, 0.0])
    np.testing.assert_allclose(target.motion(11 / rate)[1], [speed, 0.0, 0.0], atol=0.1)


def test_predictions_are_smooth_from_measurement_to_measurement():
    """5 m of noise at 5 Hz on a straight run: what is predicted 9 s ahead moves by decimetres.

    But for the few moments at which the noise looks like a turn.
    """
    target, random, before, steps = TargetFilter(0.1, 0.5), np.random.default_rng(0), None, []
    for k in range(600):
        time = 0.2 * k
        target.update(time, straight(time) + 5.0 * random.standard_normal(3))
        if time > 60.0:
            if before is not None:
                steps.append(np.linalg.norm(ahead(target, 8.8)[0] - before))
            before = ahead(target, 9.0)[0]
    assert np.quantile(steps, 0.9) < 0.5
    assert np.median(steps) < 0.2


def test_other_noise_told_is_where_the_next_track_begins():
    target = fed([0.0, 1.0], straight)
    target.tune(2.0, 0.01)
    assert target.noise != 2.0
    target.reset()
    assert (target.noise, target.agility) == (2.0, 0.01)


@pytest.mark.parametrize(
    ("velocity", "covariance", "words"),
    [
        ([np.nan, 0.0, 0.0], None, "target velocity is"),
        (None, np.eye(2), r"has shape \(2, 2\), must be \(3, 3\) or \(6, 6\)"),
        (None, np.full((3, 3), np.inf), "and finite"),
        (None, -np.eye(3), "must not be negative"),
    ],
)
def test_what_is_no_velocity_or_covariance_is_refused(velocity, covariance, words):
    target = TargetFilter(1.0, 0.5)
    with pytest.raises(ValueError, match=words):
        target.update(0.0, np.zeros(3), velocity, covariance)
    assert target.time is None


def test_threads_that_predict_at_once_share_no_numbers():
    """Flights of a campaign, and nodes of one process, have a filter each."""

    def reached(speed):
        target = fed(np.arange(0.0, 3.0, 0.1), lambda t: np.array([speed * t, 0.0, 0.0]))
        return {target.motion(3.0)[0, 0] for _ in range(2000)}

    interval = sys.getswitchinterval()
    sys.setswitchinterval(1e-6)
    try:
        with ThreadPoolExecutor(2) as threads:
            (one,), (other,) = threads.map(reached, (1.0, 2.0))
    finally:
        sys.setswitchinterval(interval)
    assert (one, other) == (pytest.approx(3.0, abs=0.5), pytest.approx(6.0, abs=0.5))
