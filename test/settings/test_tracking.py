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

import dataclasses

import numpy as np
import pytest

from uav_tracking_mpc.limits import Limit
from uav_tracking_mpc.parameters.specification import ParameterError, from_mapping, parameter
from uav_tracking_mpc.settings.tracking import TrackingParameters


@dataclasses.dataclass(frozen=True)
class Far(Limit):
    """Has a parameter of a name that the controller uses for another thing."""

    name = "far"

    horizon: float = parameter(1e4, "Greatest distance.", "m", 1.0, 1e6)


ARTIFICIAL = {"terminal_constraint": "artificial_orbit"}


def test_defaults_are_table_1():
    parameters = TrackingParameters()
    assert parameters.orbit.steady_state == pytest.approx([150.0, np.pi / 2, 50.0, 0.0, 4.0])
    assert parameters.state_weights == (0.008, 0.09, 0.05, 0.04, 0.9)
    assert (parameters.horizon, parameters.horizon_step) == (10, 1.0)
    assert parameters.terminal_scaling == 2.5


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"range": 40.0}, "^parameters 'range', 'altitude', 'airspeed': orbit range is 40.0 m"),
        ({"yaw_rate_max": 0.02}, "'yaw_rate_max' is 0.02, must exceed 0.0282843"),
        ({"airspeed": 200.0}, "steady turn rate of an orbit of radius 141.421 m at 200 m/s"),
        ({"airspeed": 20.5}, "airspeed of 20.5 m/s is not between 0 and 20 m/s"),
        ({"airspeed": 12.0, "bank_max": 0.1}, "bank 5.73 deg allows .* the nearest orbit that can"),
        ({"distance_min": 160.0}, "150.0 m range .* is nearer to the target than the 160.0 m"),
        ({"airspeed_min": 20.0}, "'airspeed_max' is 20, must be above 'airspeed_min'"),
        ({"force_max": (1.0, -30.0)}, "'force_max' is .*must be above 'force_min'"),
        ({"force_max": (-1.0, -1.0)}, "at a path angle of -?0 deg cannot be held"),
        (ARTIFICIAL | {"model": "paper"}, "'model' is 'paper', must be 'exact' with .*artificial"),
        ({"rate_lag": (0.3, 0.1, 0.2)}, r"'rate_lag' is \[0.3, 0.1, 0.2\], must be all 0 unless"),
        ({"dead_time": (0.0, 0.1, 0.0)}, r"'dead_time' is \[0.0, 0.1, 0.0\], must be all 0 unless"),
        ({"direction": "nearest"}, "'direction' is 'nearest', must be clockwise or counter_clock"),
        ({"direction": "left"}, "'direction' is .*left.*must be one of .*nearest"),
        ({"autopilot_holds": True}, "'autopilot_holds' is true, must be false unless terminal_con"),
        ({"vehicle_model": "held"}, "'autopilot_holds' is false, must not be with vehicle_model"),
        ({"model": "mine.py:Mine"}, "parameter 'model' is 'mine.py:Mine': there is no file"),
        ({"limits": f"{__file__}:Far"}, "'horizon' of Far .* must have a name of its own"),
        ({"terminal_constraint": "orbit"}, "'terminal_constraint' is .*artificial_orbit"),
    ],
)
def test_values_that_do_not_fit_together_are_refused(values, message):
    with pytest.raises(ParameterError, match=message):
        from_mapping(TrackingParameters, values)


def test_with_the_artificial_orbit_lag_dead_time_and_the_nearest_direction_are_allowed():
    parameters = TrackingParameters(
        **ARTIFICIAL, rate_lag=(0.3, 0.1, 0.2), dead_time=(0.1, 0.2, 0.1), direction="nearest"
    )
    assert parameters.orbit.direction == "clockwise"  # until the flight has chosen


def test_an_autopilot_that_holds_altitude_and_airspeed_leaves_the_turn_to_be_commanded():
    held = TrackingParameters(**ARTIFICIAL, autopilot_holds=True, dead_time=(0.1, 0.2, 0.3))
    assert (held.vehicle.name, held.vehicle.commanded) == ("held", 1)
    assert held.response.dead_times.tolist() == [0.1, 0.0, 0.0]
    law = TrackingParameters(autopilot_holds=True, law="vector_field")  # needs no problem
    assert law.vehicle.commanded == 1


@pytest.mark.parametrize(
    ("lags", "dead_times", "lags_flown", "dead_times_flown"),
    [
        ((0.3, 0.13, 0.16), (0.17, 0.2, 0.1), (0.3, 0.13, 0.16), (0.17, 0.2, 0.1)),
        ((0.5, 0.3, 0.3), (0.1, 0.65, 0.1), (0.15, 0.3, 0.0), (0.45, 0.65, 0.45)),
    ],
)
def test_dead_times_far_apart_are_brought_together_at_the_cost_of_the_lag(
    lags, dead_times, lags_flown, dead_times_flown
):
    told = TrackingParameters(**ARTIFICIAL, rate_lag=lags, dead_time=dead_times)
    flown = told.flown_by(told.response)
    assert flown.lags.tolist() == pytest.approx(lags_flown)
    assert flown.dead_times.tolist() == pytest.approx(dead_times_flown)


def test_the_envelope_has_every_limit():
    parameters = TrackingParameters(height_min=20.0, fence_radius=900.0, fence_centre=(3.0, 4.0))
    envelope = parameters.envelope
    for limit in envelope.limits:
        for field in dataclasses.fields(limit):
            assert getattr(limit, field.name) == getattr(parameters, field.name)
            assert getattr(envelope, field.name) == getattr(parameters, field.name)


def test_bounds_are_ordered_as_the_inputs():
    parameters = TrackingParameters(
        yaw_rate_max=0.5, pitch_rate_max=0.2, acceleration_min=-2.0, acceleration_max=3.0
    )
    assert parameters.input_lower == pytest.approx([-0.5, -0.2, -2.0])
    assert parameters.input_upper == pytest.approx([0.5, 0.2, 3.0])
