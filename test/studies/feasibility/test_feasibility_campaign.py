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

"""Short form of the campaign: what is guaranteed shows."""

from uav_tracking_mpc.settings.configuration import load_configuration
from uav_tracking_mpc.studies.feasibility.feasibility_campaign import (
    FlightCounts,
    campaign,
    summary,
)
from uav_tracking_mpc.studies.feasibility.random_flights import random_situations

PARAMETERS = load_configuration("small_uav").controller


def test_twenty_states():
    situations = random_situations(PARAMETERS, 20, seed=3)
    flights = campaign(PARAMETERS, situations, workers=1, show=False)
    counts = summary(flights)
    assert counts["states"] == 20
    assert counts["cold_failures"] == 0
    assert counts["steps"] == counts["converged"] == counts["feasible"] == 20 * 40
    assert counts["cost_rises"] == 0
    still = counts["without_drift"]
    assert 0 < still["states"] < 20
    assert still["feasible"] == still["steps"]
    assert 0.0 < counts["warm_us"]["median"] <= counts["warm_us"]["p99"]


def test_sums():
    good = FlightCounts(False, False, 3, 3, 3, 0, 0.0, 100.0, (10.0, 20.0))
    bad = FlightCounts(True, True, 1, 0, 0, 0, 0.0, 300.0, ())
    rising = FlightCounts(True, False, 3, 3, 2, 1, 0.5, 200.0, (30.0, 40.0))
    counts = summary([good, bad, rising])
    assert (counts["states"], counts["cold_failures"], counts["steps"]) == (3, 1, 7)
    assert (counts["converged"], counts["feasible"]) == (6, 5)
    assert (counts["cost_rises"], counts["worst_rise"]) == (1, 0.5)
    assert counts["cold_us"]["median"] == 200.0
    assert counts["warm_us"]["median"] == 25.0
    assert counts["without_drift"]["cost_rises"] == 0
    assert summary([])["warm_us"] == {"median": None, "p99": None}
