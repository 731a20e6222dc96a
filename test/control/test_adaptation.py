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

"""What the aircraft shows is flown by, slowly, and only where it contradicts what was told."""

import dataclasses
from types import SimpleNamespace

import numpy as np
import pytest
import small_uav

from uav_tracking_mpc.control.adaptation import PERIOD, SPEED, TAKING_OVER, ResponseAdaptation
from uav_tracking_mpc.control.controller import Controller
from uav_tracking_mpc.control.event import EventLog
from uav_tracking_mpc.control.watches import Swing
from uav_tracking_mpc.dynamics.vehicle_models import VehicleModel
from uav_tracking_mpc.dynamics.vehicle_models.lagged import Lagged
from uav_tracking_mpc.estimation.measurement import Measurement
from uav_tracking_mpc.estimation.response_estimator import ChannelResponse
from uav_tracking_mpc.parameters.specification import ParameterError
from uav_tracking_mpc.settings.configuration import load_configuration
from uav_tracking_mpc.settings.tracking import TrackingParameters
from uav_tracking_mpc.simulation.closed_loop import simulate
from uav_tracking_mpc.simulation.plants import plant_of

TOLD = small_uav.parameters()
DEVIATIONS = ("lag_deviation", "dead_time_deviation", "delay_deviation", "gain_deviation")
TRUSTED = dict.fromkeys(("trusted", "lag_trusted", "gain_trusted"), True)
SURE = dict.fromkeys(DEVIATIONS, 0.01) | TRUSTED


def adaptation(*channels, told=TOLD):
    """One that has found these channels."""
    found = ResponseAdaptation(told, EventLog())
    found.estimator.channels = [*channels, *[ChannelResponse()] * (3 - len(channels))]
    return found


def followed(found, seconds):
    changes = [found.follow(tick * 0.05) for tick in range(round(seconds / 0.05))]
    return [change for change in changes if change is not None]


def test_it_follows_slowly_what_is_trusted():
    found = adaptation(ChannelResponse(lag=0.5, dead_time=0.3, gain=1.2, **SURE))
    first, *_ = changes = followed(found, 30.0)
    assert abs(first.lags[0] - TOLD.rate_lag[0]) <= SPEED * PERIOD + 1e-12
    delays = np.array([p.lags[0] + p.dead_times[0] for p in changes])
    assert np.all(np.abs(np.diff(delays)) <= SPEED * PERIOD + 1e-12)
    assert found.flown.lags[0] == pytest.approx(0.5)
    assert found.flown.dead_times[0] == pytest.approx(0.3)
    assert found.flown.gains.tolist() == pytest.approx([1.2, 1.0, 1.0])
    assert tuple(changes[-1].lags[1:]) == pytest.approx(TOLD.rate_lag[1:])


@pytest.mark.parametrize(
    "channel",
    [
        ChannelResponse(lag=0.9, dead_time=0.9, gain=1.5),  # not trusted
        ChannelResponse(TOLD.rate_lag[0] + 0.01, TOLD.dead_time[0], 1.01, **SURE),  # the same
        ChannelResponse(0.35, 0.2, 1.05, **dict.fromkeys(DEVIATIONS, 0.05), **TRUSTED),  # doubtful
    ],
)
def test_what_was_told_is_flown_unless_it_is_contradicted(channel):
    found = adaptation(channel)
    assert followed(found, 10.0) == []
    np.testing.assert_array_equal(found.flown, TOLD.response)


def test_a_premature_estimate_is_taken_back():
    found = adaptation(ChannelResponse(lag=0.5, dead_time=0.4, gain=1.2, **SURE))
    followed(found, 5.0)
    found.estimator.channels[0] = ChannelResponse(TOLD.rate_lag[0], TOLD.dead_time[0], **SURE)
    found.interrupt()
    followed(found, 20.0)
    np.testing.assert_array_equal(found.flown, TOLD.response)


def test_what_was_learnt_stays_while_nothing_is_trusted():
    found = adaptation(ChannelResponse(lag=0.5, dead_time=0.4, gain=1.2, **SURE))
    followed(found, 30.0)
    found.estimator.channels[0] = ChannelResponse(lag=0.1)
    found.interrupt()
    assert followed(found, 10.0) == []
    assert found.flown.lags[0] == pytest.approx(0.5)


def test_what_was_learnt_goes_once_a_doubtful_estimate_contradicts_it():
    found = adaptation(ChannelResponse(lag=0.5, dead_time=0.3, **SURE))
    followed(found, 30.0)
    found.estimator.channels[0] = ChannelResponse(0.3, 0.2, delay_deviation=0.12)
    found.interrupt()
    followed(found, 30.0)
    assert found.delays[0] == pytest.approx(sum(TOLD.response.lags[:1] + TOLD.dead_time[:1]))


def test_a_lag_that_is_known_without_its_sum_does_not_become_dead_time():
    found = adaptation(ChannelResponse(0.0, 0.05, **SURE | {"trusted": False}))
    followed(found, 30.0)
    np.testing.assert_array_equal(found.flown, TOLD.response)


def test_a_sum_that_is_known_alone_is_shared_as_it_was_told():
    found = adaptation(ChannelResponse(0.1, 0.6, **SURE | {"lag_trusted": False}))
    followed(found, 30.0)
    lag, dead_time = TOLD.rate_lag[0], TOLD.dead_time[0]
    assert found.delays[0] == pytest.approx(0.7)
    assert found.flown.lags[0] == pytest.approx(0.7 * lag / (lag + dead_time))


def test_it_is_off_where_it_is_not_asked_for_or_a_law_is_flown():
    channel = ChannelResponse(lag=0.5, dead_time=0.4, gain=1.2, **SURE)
    for change in ({"response_estimation": False}, {"law": "vector_field"}):
        found = adaptation(channel, told=dataclasses.replace(TOLD, **change))
        assert followed(found, 10.0) == []
        assert np.all(found.flown.gains == 1.0)


def test_what_was_learnt_survives_a_change_unless_that_tells_another_response():
    found = adaptation(ChannelResponse(lag=0.5, dead_time=0.4, **SURE))
    followed(found, 30.0)
    flown = found.tell(dataclasses.replace(TOLD, range=350.0))
    assert flown.lags[0] == pytest.approx(0.5)
    told = dataclasses.replace(TOLD, rate_lag=(0.2, 0.1, 0.1))
    assert found.tell(told) is None
    np.testing.assert_array_equal(found.flown, told.response)


def test_a_dead_time_that_no_parameter_may_have_is_flown_by():
    told = dataclasses.replace(TOLD, control_rate=4.0)
    controller = Controller(told, stopwatch=lambda: 0.0)  # the machine may be busy
    controller.response.estimator.channels[0] = ChannelResponse(0.3, 2.35, **SURE)
    controller.see_target(0.0, np.zeros(3))
    for time in np.arange(0.0, 95.0, 0.25):
        here = np.array([300.0, 22.0 * time, 120.0])
        velocity = np.array([0.0, 22.0, 0.0])
        state = Measurement(time, here, velocity, np.pi / 2, 0.0, airspeed=22.0)
        controller.response.estimator.see = lambda *_: None  # knows already
        controller.see_target(state.stamp, here - [300.0, 0.0, 120.0])
        command = controller.step(state, state.stamp)
        assert np.isfinite(command.inputs).all()
    assert controller.response.delays[0] == pytest.approx(2.65)
    assert controller.response.flown.dead_times[0] == pytest.approx(2.35)


def test_a_model_that_has_no_lags_to_change_takes_what_is_learnt_as_dead_time(monkeypatch):
    monkeypatch.setattr(Lagged, "with_lags", VehicleModel.with_lags)
    found = adaptation(ChannelResponse(lag=0.5, dead_time=0.4, **SURE))
    followed(found, 30.0)
    assert tuple(found.flown.lags) == TOLD.rate_lag
    assert found.delays[0] == pytest.approx(0.9)


def test_commands_are_what_is_wanted_divided_by_the_gain():
    controller = Controller(TOLD)
    found = adaptation(ChannelResponse(0.3, 0.17, 0.8, **SURE))
    followed(found, 10.0)
    plan = np.array([[0.1, 0.02, 0.5]])
    np.testing.assert_allclose(found.commanded(0.0, 0.0, plan, 0.4), [[0.08, 0.02, 0.5]])
    assert controller.response.reset() is None  # nothing was learnt


def test_nothing_is_learnt_while_an_aircraft_rolls_over_to_what_is_commanded():
    """As quickly as it can roll is neither lag nor dead time."""
    found = ResponseAdaptation(TOLD, EventLog())
    assert found.enabled

    def seen(stamp):
        measurement = Measurement(stamp, np.zeros(3), np.array([22.0, 0.0, 0.0]), 0.0, 0.0)
        found.see(measurement, np.array([0.0, 0.0, 0.0, 0.0, 0.0, 22.0]), True)
        return found.enabled

    found.engage(False)
    assert not seen(10.0)
    found.engage(True)
    assert not seen(20.0)
    assert not seen(20.0 + 0.9 * TAKING_OVER)
    assert seen(20.0 + 1.1 * TAKING_OVER)
    assert not seen(0.0)  # time has gone back
    assert seen(1.1 * TAKING_OVER)


def test_the_paper_s_formulation_refuses_it():
    with pytest.raises(ParameterError, match="'response_estimation' is true, must be false unless"):
        TrackingParameters(response_estimation=True)


def test_a_flight_that_was_told_half_of_it_finds_the_truth():
    told = ["nmpc_controller.rate_lag=[0.15, 0.06, 0.08]",
            "nmpc_controller.dead_time=[0.08, 0.1, 0.05]", "mission.duration=40.0"]  # fmt: skip
    flown = []

    class Observed(Controller):
        def __init__(self, *arguments, **named):
            super().__init__(*arguments, **named)
            flown.append(self)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("uav_tracking_mpc.simulation.closed_loop.Controller", Observed)
        configuration = load_configuration("small_uav", told, "crosswind")
        simulate(configuration)
    (controller,) = flown
    assert controller.response.delays[0] == pytest.approx(0.47, abs=0.05)
    assert controller.response.delays[1] == pytest.approx(0.33, abs=0.05)
    assert controller.parameters.rate_lag == (0.15, 0.06, 0.08)  # what was told
    controller.reset()
    assert controller.response.delays[0] == pytest.approx(0.23)


def test_what_the_autopilot_holds_is_not_learnt():
    told = small_uav.parameters("autopilot_holds=true")
    found = ResponseAdaptation(told, EventLog())
    configuration = load_configuration("small_uav")
    measurement = plant_of(configuration).measured()
    rng = np.random.default_rng(3)
    for tick in range(1200):
        rates = 0.1 * rng.standard_normal(2)
        now = dataclasses.replace(
            measurement, stamp=0.05 * tick, turn_rate=rates[0], path_angle_rate=rates[1]
        )
        found.see(now, now.state(22.0 + rng.standard_normal()), True)
        plan = 0.1 * rng.standard_normal((1, 3))
        found.commanded(now.stamp, 0.0, plan, 0.4)
    turn, path, speed = found.estimator.channels
    assert turn != ChannelResponse()
    assert path == speed == ChannelResponse()


def test_an_autopilot_that_swings_in_height_is_not_told_as_a_limit_cycle_of_ours():
    for holds, told in (("false", True), ("true", False)):
        events = EventLog()
        found = ResponseAdaptation(small_uav.parameters(f"autopilot_holds={holds}"), events)
        measurement = plant_of(load_configuration("small_uav")).measured()
        for tick in range(800):
            now = dataclasses.replace(measurement, stamp=0.05 * tick)
            found.see(now, now.state(22.0), True)
            plan = np.array([[0.0, 0.3 * np.sin(4.0 * now.stamp), 0.0]])
            found.commanded(now.stamp, 0.0, plan, 0.4)
        assert any("limit cycle" in event.words for event in events.take()) is told


def test_the_estimator_is_told_which_channels_are_softened():
    found = adaptation()
    found.oscillation = SimpleNamespace(
        swings=(None, Swing(period=3.0, amplitude=0.2)), going_on=(False, True)
    )
    factors = found.soften(100.0)
    assert factors[1] > 1.0
    np.testing.assert_array_equal(found.estimator.swing, [False, True, False])
