from types import SimpleNamespace

import pytest

pytest.importorskip("rclpy")

from uav_tracking_mpc.studies.faults.kinds.solver_budget import SolverBudget


def test_the_least_budget_is_asked_for_last_and_put_back():
    asked = []
    client = SimpleNamespace(
        ask=lambda values: asked.append(values["solve_time_max"]),
        put_back=lambda: asked.append("put back"),
        settled=False,
    )
    flight, fault = SimpleNamespace(parameters=client), SolverBudget()
    fault.begin(flight, 1.0, 0)
    fault.end(flight)
    assert asked == [*sorted(asked[:-1], reverse=True), "put back"]
    assert not fault.settled(flight)
