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

"""Two short flights by classical laws, and one that stands in for the controller's."""

from functools import cache

from uav_tracking_mpc.settings.configuration import load_configuration
from uav_tracking_mpc.studies.comparison.flights import fly_all
from uav_tracking_mpc.studies.comparison.mismatches import mismatched, settled_after
from uav_tracking_mpc.studies.comparison.results import Scenario, scenario_of

LAWS = ("nmpc", "l1")
KEYS = {  # of a flight in the JSON
    "range_rms_m",
    "range_mean_m",
    "worst_m",
    "settling_s",
    "altitude_rms_m",
    "airspeed_rms_mps",
    "bank_rate_rms_dps",
    "envelope_violations",
    "violations",
    "off_plan",
}


@cache
def compared(name="gusts", duration=12.0, config="small_uav") -> Scenario:
    """Flights of l1 and, under the name of nmpc, of vector_field."""
    overrides = [f"mission.duration={duration}"]
    configuration = load_configuration(config, overrides, name)
    (logs,) = fly_all([configuration], ("vector_field", "l1"), workers=1, show=False)
    return scenario_of(name, configuration, LAWS, logs)


@cache
def mistold(name="lag_2", duration=12.0) -> Scenario:
    """The same under a mismatch."""
    configuration = mismatched("small_uav", name, (f"mission.duration={duration}",))
    (logs,) = fly_all([configuration], ("vector_field", "l1"), workers=1, show=False)
    return scenario_of(name, configuration, LAWS, logs, settled_after(configuration))
