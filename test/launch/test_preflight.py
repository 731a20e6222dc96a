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

"""Before a flight: what a link says becomes the controller's envelope, or a refusal in words."""

from pathlib import Path

import numpy as np
import pytest

from uav_tracking_mpc.launch.preflight import preflight, refusal, refuse, with_envelope
from uav_tracking_mpc.links.px4 import Px4Envelope
from uav_tracking_mpc.parameters.specification import ParameterError
from uav_tracking_mpc.settings.configuration import load_configuration

LINK = f"{Path(__file__).parents[1] / 'paced_link.py'}:PacedLink"


def configuration(*overrides, address="", link=LINK):
    own = [f"autopilot_link.link={link}", f"autopilot_link.connection={address!r}"]
    return load_configuration("small_uav", [*own, *overrides])


def fitted(envelope, overrides=(), name="small_uav"):
    settings = [f"nmpc_controller.{override}" for override in overrides]
    return with_envelope(load_configuration(name, settings), envelope)


def test_a_vehicle_tightens_what_was_asked_for_and_never_loosens_it():
    flown, changes = fitted({"bank_max": 0.7, "airspeed_min": 12.0, "airspeed_max": 32.0})
    assert flown.controller.bank_max == 0.7
    assert flown.controller.airspeed_min == 14.0
    assert changes == ("bank_max is 0.7 by the vehicle, not 0.7854",)
    assert flown.sections["nmpc_controller"]["bank_max"] == 0.7
    assert flown.name == "small_uav"
    assert fitted({"bank_max": 1.1}) == (load_configuration("small_uav"), ())


def test_what_an_autopilot_holds_is_its_own_and_no_limit():
    flown, _ = fitted({"hold_climb_max": 9.0, "rate_lag": (0.2, 0.2, 0.2)})
    assert flown.controller.hold_climb_max == 9.0
    assert flown.controller.rate_lag == (0.2, 0.2, 0.2)


def test_the_force_that_is_left_is_within_both_at_every_airspeed():
    vehicle = {"airspeed_min": 10.0, "airspeed_max": 26.0}
    vehicle |= {"force_min": (-1.0, -2.0), "force_max": (2.0, 1.6)}
    flown = fitted(vehicle)[0].controller
    asked = load_configuration("small_uav").controller
    assert (flown.airspeed_min, flown.airspeed_max) == (14.0, 26.0)
    for airspeed in np.linspace(14.0, 26.0, 13):
        least = np.interp(airspeed, (10.0, 26.0), vehicle["force_min"])
        most = np.interp(airspeed, (10.0, 26.0), vehicle["force_max"])
        own = [
            np.interp(airspeed, (14.0, 32.0), each) for each in (asked.force_min, asked.force_max)
        ]
        left = [
            np.interp(airspeed, (14.0, 26.0), each) for each in (flown.force_min, flown.force_max)
        ]
        assert max(least, own[0]) - 1e-9 <= left[0] < left[1] <= min(most, own[1]) + 1e-9


def test_the_small_airplane_of_px4_is_flown_by_its_own_configuration():
    """Its parameters are PX4's own defaults; they loosen nothing and fit the orbit."""
    own = {"FW_R_LIM": 50.0, "FW_AIRSPD_MIN": 10.0, "FW_AIRSPD_TRIM": 15.0, "FW_AIRSPD_MAX": 20.0}
    envelope = Px4Envelope(own, 1.0)
    assert envelope.refusals() == []
    flown, changes = fitted(envelope.values(12.5), name="px4_uav")
    asked = load_configuration("px4_uav").controller
    assert flown.controller.airspeed == 12.5
    assert flown.controller.airspeed_max == asked.airspeed_max <= 14.0
    assert flown.controller.bank_max == asked.bank_max
    assert not any("airspeed" in words for words in changes)
    assert refusal(flown.controller, np.array([5.0, 0.0, 0.0])) == ""


@pytest.mark.parametrize(
    ("name", "asked", "vehicle", "flown"),
    [
        ("bank_max", 0.6, 0.7, 0.6),
        ("bank_max", 0.9, 0.7, 0.7),
        ("airspeed_min", 16.0, 15.0, 16.0),
        ("airspeed_min", 10.0, 15.0, 15.0),
        ("path_angle_min", -0.1, -0.2, -0.1),
    ],
)
def test_what_was_asked_for_counts_where_it_is_tighter(name, asked, vehicle, flown):
    got, _ = fitted({name: vehicle}, overrides=[f"{name}={asked}"])
    assert getattr(got.controller, name) == flown


def test_the_floor_of_the_configuration_stays_where_it_is_higher():
    assert fitted({"height_min": 10.0})[0].controller.height_min == 30.0
    assert fitted({"height_min": 60.0})[0].controller.height_min == 60.0


@pytest.mark.parametrize(
    ("radius", "centre", "flown"), [(900.0, 0.0, 500.0), (600.0, 200.0, 600.0), (400.0, 0.0, 400.0)]
)
def test_the_fence_inside_the_other_counts_else_the_vehicles(radius, centre, flown):
    envelope = {"fence_radius": radius, "fence_centre": (centre, 0.0)}
    got, _ = fitted(envelope, overrides=["fence_radius=500.0"])
    assert got.controller.fence_radius == flown


def test_an_orbit_that_the_vehicle_cannot_fly_is_refused_in_words():
    with pytest.raises(ParameterError, match=r"needs a turn rate of .* bank 5\.73 deg"):
        fitted({"bank_max": 0.1})


def test_a_wind_may_be_too_much_for_the_orbit():
    controller = load_configuration("small_uav", ["nmpc_controller.bank_max=0.25"]).controller
    assert refusal(controller, np.zeros(3)) == ""
    words = refusal(controller, np.array([6.0, 8.0, 3.0]))
    assert words.startswith("in the wind of 10.0 m/s there: an orbit of 300.0 m")


def test_a_link_is_looked_at_and_let_go():
    found = preflight(configuration(), 1.0)
    assert found.inspection.found == {"firmware": "paced 1.0"}
    assert found.refusals == ()
    assert found.configuration.controller.bank_max == 0.7
    assert found.configuration.controller.height_min == 30.0
    assert found.configuration.link == configuration().link
    np.testing.assert_allclose(found.wind, np.zeros(3), atol=0.1)
    refuse(found)
