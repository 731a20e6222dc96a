import numpy as np
import pytest

from uav_tracking_mpc.guidance.target_filter import TargetFilter


def fed(times, path, noise=0.0, agility=0.5, seed=0):
    random = np.random.default_rng(seed)
    target = TargetFilter(max(noise, 0.1), agility)
    for time in times:
        target.update(time, path(time) + noise * random.standard_normal(3))
    return target


def test_a_target_that_stands_is_where_it_was_measured():
    target = fed(np.arange(0, 5, 0.1), lambda t: np.array([3.0, -4.0, 1.0]))
    position, velocity = target.predict(10.0)
    np.testing.assert_array_equal(position, [3.0, -4.0, 1.0])
    np.testing.assert_array_equal(velocity, 0.0)


def test_a_straight_run_is_learned_and_predicted():
    def path(t):
        return np.array([5.0 * t, -2.0 * t, 0.0])

    position, velocity = fed(np.arange(0, 20, 0.2), path).predict(22.0)
    np.testing.assert_allclose(velocity, [5.0, -2.0, 0.0], atol=0.02)
    np.testing.assert_allclose(position, path(22.0), atol=0.1)


def test_irregular_times_do_no_harm():
    times = np.cumsum(np.random.default_rng(3).uniform(0.02, 1.5, 80))
    _, velocity = fed(times, lambda t: np.array([4.0 * t, 0.0, 0.0])).predict(times[-1])
    np.testing.assert_allclose(velocity, [4.0, 0.0, 0.0], atol=0.05)


def test_noise_is_reduced():
    """3 m of noise at 5 Hz on a target that stands."""
    errors = []
    for seed in range(20):
        target = fed(
            np.arange(0, 40, 0.2), lambda t: np.zeros(3), noise=3.0, agility=0.05, seed=seed
        )
        errors.append(target.predict(40.0)[0])
    assert np.std(errors) < 1.5


def test_old_measurements_are_left_out():
    target = fed([0.0, 1.0, 2.0], lambda t: np.array([t, 0.0, 0.0]))
    before = target.predict(3.0)
    assert not target.update(1.5, [100.0, 0.0, 0.0])
    assert not target.update(2.0, [100.0, 0.0, 0.0])
    np.testing.assert_array_equal(target.predict(3.0), before)


@pytest.mark.parametrize("position", [[np.nan, 0, 0], [0, 0], [np.inf, 0, 0], [[0, 0, 0]]])
def test_what_is_no_position_is_refused_and_changes_nothing(position):
    target = fed([0.0, 1.0], lambda t: np.zeros(3))
    before = target.predict(2.0)
    with pytest.raises(ValueError, match="three finite numbers"):
        target.update(1.5, position)
    np.testing.assert_array_equal(target.predict(2.0), before)


def test_nothing_measured_is_said():
    with pytest.raises(ValueError, match="no target position"):
        TargetFilter(0.1, 0.5).predict(0.0)
