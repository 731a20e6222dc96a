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
from uav_tracking_mpc.links import LinkError, LinkRefusedError
from uav_tracking_mpc.parameters.registry import ExtensionError
from uav_tracking_mpc.parameters.specification import ParameterError
from uav_tracking_mpc.settings.configuration import load_configuration

LINK = f"{Path(__file__).parents[1] / 'paced_link.py'}:PacedLink"


def configuration(*overrides, address="", link=LINK):
    own = [f"autopilot_link.link={link}", f"autopilot_link.connection={address!r}"]
    return load_configuration("small_uav", [*own, *overrides])


def fitted(envelope, told=(), overrides=()):
    settings = [f"nmpc_controller.{override}" for override in overrides]
    return with_envelope(load_configuration("small_uav", settings), envelope, told)


def test_the_vehicles_limits_take_the_place_of_the_configurations():
    flown, changes = fitted({"bank_max": 1.0, "airspeed_min": 12.0, "airspeed_max": 32.0})
    assert flown.controller.bank_max == 1.0
    assert flown.controller.airspeed_min == 12.0
    assert len(changes) == 2  # the airspeed_max is the same
    assert changes[0] == "bank_max is 1 by the vehicle, not 0.7854"
    assert flown.sections["nmpc_controller"]["bank_max"] == 1.0
    assert flown.name == "small_uav"


@pytest.mark.parametrize(
    ("name", "asked", "vehicle", "flown"),
    [
        ("bank_max", 0.6, 0.7, 0.6),
        ("bank_max", 0.9, 0.7, 0.7),
        ("airspeed_min", 16.0, 15.0, 16.0),
        ("airspeed_min", 10.0, 15.0, 15.0),
        ("path_angle_min", -0.1, -0.2, -0.1),
        ("rate_lag", [0.3, 0.1, 0.1], (0.2, 0.2, 0.2), (0.2, 0.2, 0.2)),
    ],
)
def test_what_was_asked_for_counts_where_it_is_tighter(name, asked, vehicle, flown):
    got, _ = fitted({name: vehicle}, told={name}, overrides=[f"{name}={asked}"])
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
    found = preflight(configuration(), (), 1.0)
    assert found.inspection.found == {"firmware": "paced 1.0"}
    assert found.refusals == ()
    assert found.configuration.controller.bank_max == 0.7
    assert found.configuration.controller.height_min == 30.0
    assert found.configuration.link == configuration().link
    np.testing.assert_allclose(found.wind, np.zeros(3), atol=0.1)
    refuse(found)


@pytest.mark.parametrize(
    ("address", "words"), [("tight", "needs a turn rate"), ("disarmed", "disarmed")]
)
def test_what_cannot_be_flown_is_refused(address, words):
    found = preflight(configuration(address=address), (), 1.0)
    with pytest.raises(LinkRefusedError, match=words):
        refuse(found)


@pytest.mark.parametrize(
    ("chosen", "error", "words"),
    [
        ({"address": "nobody"}, LinkError, "nobody answers"),
        ({"address": "copter"}, LinkRefusedError, "it is a copter"),
        ({"link": "nowhere.py:Link"}, ExtensionError, "there is no file"),
    ],
)
def test_an_aircraft_that_is_not_there_is_an_error(chosen, error, words):
    with pytest.raises(error, match=words):
        preflight(configuration(**chosen), (), 1.0)
