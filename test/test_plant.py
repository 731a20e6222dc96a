import numpy as np
import pytest

from uav_tracking_mpc.dynamics.relative import relative_state
from uav_tracking_mpc.dynamics.vehicle import advance
from uav_tracking_mpc.parameters import ParameterError
from uav_tracking_mpc.simulation.plant import Plant, SimulatorParameters

LEVEL_FLIGHT = SimulatorParameters(initial_speed=5.0, initial_path_angle=0.2)


def test_default_start_is_the_papers(paper_start):
    np.testing.assert_allclose(
        relative_state(SimulatorParameters().initial_state, np.zeros(3)), paper_start, atol=1e-12
    )


def test_plan_is_flown_segment_by_segment():
    plant = Plant(LEVEL_FLIGHT)
    plan = [[0.1, 0.0, 0.5], [-0.2, 0.1, 0.0]]
    plant.accept(plan, [0.0, 1.0])
    expected = advance(advance(plant.state, plan[0], 1.0), plan[1], 1.0)
    for _ in range(20):
        plant.advance(0.1)
    np.testing.assert_allclose(plant.state, expected, atol=1e-12)
    assert plant.failsafes == 0


def test_when_the_plan_is_over_the_wings_are_levelled():
    plant = Plant(LEVEL_FLIGHT)
    plant.accept([[0.3, 0.1, 0.5]], [0.0])
    for _ in range(200):
        plant.advance(0.05)
    assert plant.holding
    assert plant.failsafes == 1
    heading, path_angle, speed = plant.state[3:]
    plant.advance(1.0)
    assert plant.state[3] == pytest.approx(heading)
    assert path_angle == pytest.approx(0.0, abs=1e-3)
    assert plant.state[5] == pytest.approx(speed)


def test_a_new_plan_ends_the_hold():
    plant = Plant(LEVEL_FLIGHT)
    plant.advance(1.0)
    plant.accept([[0.3, 0.0, 0.0]], [plant.time])
    plant.advance(0.1)
    assert not plant.holding
    assert plant.failsafes == 0  # waiting for the first command is no failsafe


def test_commands_are_saturated():
    plant = Plant(LEVEL_FLIGHT)
    plant.accept([[9.0, -9.0, 9.0]], [0.0])
    np.testing.assert_allclose(plant.inputs(), [np.pi / 4, -np.pi / 4, 1.0])


def test_speed_stays_inside_its_limits():
    plant = Plant(SimulatorParameters(initial_speed=1.0, speed_max=2.0))
    plant.accept([[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]], [0.0, 5.0])
    speeds = [plant.advance(0.3)[5] for _ in range(33)]
    assert max(speeds) == pytest.approx(2.0)
    assert min(speeds) >= 0.0


@pytest.mark.parametrize(
    ("plan", "starts"),
    [
        ([[np.nan, 0, 0]], [0.0]),
        ([[0, 0, 0]], [np.inf]),
        ([], []),
        ([[0, 0]], [0.0]),
        ([[0, 0, 0]] * 2, [1.0, 1.0]),
        ([[0, 0, 0]] * 2, [1.0]),
    ],
)
def test_a_bad_plan_is_refused_and_the_present_one_stays(plan, starts):
    plant = Plant(LEVEL_FLIGHT)
    plant.accept([[0.1, 0.0, 0.0]], [0.0])
    with pytest.raises(ValueError, match="plan"):
        plant.accept(plan, starts)
    np.testing.assert_allclose(plant.inputs(), [0.1, 0.0, 0.0])


@pytest.mark.parametrize(
    ("values", "name"),
    [
        ({"speed_min": 9.0, "speed_max": 8.0}, "speed_min"),
        ({"initial_speed": 30.0}, "initial_speed"),
    ],
)
def test_limits_that_do_not_fit_are_named(values, name):
    with pytest.raises(ParameterError, match=name):
        SimulatorParameters(**values)


def test_a_plan_from_the_future_is_refused():
    plant = Plant(LEVEL_FLIGHT)
    with pytest.raises(ValueError, match=r"begins 3600.000 s from now"):
        plant.accept([[0.3, 0.0, 0.0]], [3600.0])
    assert not plant.commanded


def test_a_plan_older_than_the_one_that_is_flown_is_refused():
    plant = Plant(LEVEL_FLIGHT)
    plant.accept([[0.1, 0.0, 0.0]], [0.5])
    with pytest.raises(ValueError, match="older"):
        plant.accept([[0.2, 0.0, 0.0]], [0.4])
