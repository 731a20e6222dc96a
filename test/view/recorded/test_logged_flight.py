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

"""A log as a page shows it."""

import numpy as np

from uav_tracking_mpc.dynamics.orbit import Orbit
from uav_tracking_mpc.settings.configuration import load_configuration
from uav_tracking_mpc.simulation.flight_log import FlightLog
from uav_tracking_mpc.view.recorded.logged_flight import LoggedSource

FIRST, SECOND = Orbit(300.0, 120.0, 22.0), Orbit(400.0, 150.0, 20.0)
TIME = np.arange(0.0, 10.0, 0.5)


def test_the_orbit_that_is_wanted_changes_as_it_was_asked_for():
    still = np.zeros((len(TIME), 3))
    log = FlightLog(
        config="small_uav",
        duration=10.0,
        speed=0.0,
        model="exact",
        plant="vehicle",
        orbit=SECOND,
        orbits=((1.0, FIRST), (6.0, SECOND)),
        input_lower=-np.ones(3),
        input_upper=np.ones(3),
        time=TIME,
        vehicle=np.column_stack(
            [np.add(still, [275.0, 0.0, 120.0]), still[:, :2], 22.0 + still[:, 0]]
        ),
        target=still,
        command_time=TIME,
        inputs=still,
        cost=still[:, 0],
        solve_time=still[:, 0],
        solver="newton",
    )
    source = LoggedSource(log, load_configuration("small_uav").controller)
    source.clock.pause()
    wanted = []
    for time in (0.0, 5.0, 7.0):
        source.clock.seek(time)
        wanted.append(source.flights()[0].sight.wanted.centre[2])
    np.testing.assert_allclose(wanted, [120.0, 120.0, 150.0])
