"""Two short flights by classical laws, and one that stands in for the controller's."""

from functools import cache

from uav_tracking_mpc.comparison.flights import fly_all, prepared
from uav_tracking_mpc.comparison.results import Scenario, scenario_of
from uav_tracking_mpc.simulation.configuration import load_configuration

LAWS = ("nmpc", "l1")


@cache
def compared(name="gusts", duration=12.0, config="small_uav") -> Scenario:
    """Flights of l1 and, under the name of nmpc, of vector_field."""
    overrides = [f"mission.duration={duration}"]
    configuration = prepared(load_configuration(config, overrides, name))
    (logs,) = fly_all([configuration], ("vector_field", "l1"), workers=1, show=False)
    return scenario_of(name, configuration, LAWS, logs)
