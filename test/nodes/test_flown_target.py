"""Where the target of a recorded flight was."""

import numpy as np
import pytest

from uav_tracking_mpc.nodes.flown_target import sighted_target, simulated_target
from uav_tracking_mpc.settings.configuration import load_configuration

BEGAN = 1_700_000_000_000_000_000
SECOND = 1_000_000_000


def test_a_simulated_target_moves_from_when_it_began():
    overrides = ["target_publisher.motion=line", "target_publisher.speed=2.0"]
    target = load_configuration("small_uav", overrides).target
    flown = simulated_target(target, BEGAN, [BEGAN, BEGAN + 3 * SECOND])
    np.testing.assert_allclose(flown.position[:, 0], [0.0, 6.0])
    np.testing.assert_allclose(flown.velocity, [[2.0, 0.0, 0.0]] * 2)
    assert simulated_target(target, BEGAN, []).position.shape == (0, 3)


def test_a_sighted_target_is_interpolated():
    sightings = [(BEGAN + k * SECOND, np.array([3.0 * k, -k, 1.0])) for k in (0, 2, 1, 3)]
    flown = sighted_target(sightings, [BEGAN + SECOND // 2, BEGAN + 2 * SECOND])
    np.testing.assert_allclose(flown.position, [[1.5, -0.5, 1.0], [6.0, -2.0, 1.0]])
    np.testing.assert_allclose(flown.velocity, [[3.0, -1.0, 0.0]] * 2)


def test_a_target_that_was_seen_once_stands():
    flown = sighted_target([(BEGAN, np.ones(3))], [BEGAN + SECOND])
    np.testing.assert_allclose(flown.position, [[1.0, 1.0, 1.0]])
    np.testing.assert_allclose(flown.velocity, [[0.0, 0.0, 0.0]])


def test_a_target_that_was_never_seen_is_an_error():
    with pytest.raises(ValueError, match="no position of the target"):
        sighted_target([], [BEGAN])
