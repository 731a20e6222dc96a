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

"""What flies, beside the model; and flights on both sides of the margins."""

import json
import math
from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from uav_tracking_mpc.margins.loop_margins import UNSTABLE, loop_margins
from uav_tracking_mpc.margins.orbit_loop import OrbitLoop
from uav_tracking_mpc.parameters.specification import ParameterError
from uav_tracking_mpc.report.figure_style import png
from uav_tracking_mpc.settings.configuration import load_configuration
from uav_tracking_mpc.simulation.closed_loop import simulate
from uav_tracking_mpc.studies.margins import margin_study as module
from uav_tracking_mpc.studies.margins.margin_study import (
    FlownLoop,
    as_json,
    disturbed,
    flown_loops,
    in_still_air,
    margin_study,
    sensitivities,
)
from uav_tracking_mpc.studies.margins.margin_study import margins as study_of


@pytest.fixture(autouse=True)
def short(monkeypatch):
    """A still target in still air needs no time to settle."""
    monkeypatch.setattr(module, "SETTLED", 10.0)
    monkeypatch.setattr(module, "OBSERVED", 40.0)


@pytest.fixture(scope="module")
def configuration():
    return load_configuration("small_uav", scenario="gusts")


@pytest.fixture(scope="module")
def near(configuration):
    return OrbitLoop(configuration.controller)


@pytest.fixture(scope="module")
def margins(near):
    return near.margins(near.orbit_in(np.zeros(3)))


def test_an_impulse_lasts_for_one_period():
    impulse = partial(disturbed, np.array([0.1, 0.0, 0.0]), 0.05)
    ticks = [tick / 20.0 for tick in range(190, 212)]
    assert [time for time in ticks if np.any(impulse(time))] == [10.0]


def test_still_air_takes_away_what_is_no_error_of_the_aircraft(configuration):
    still = in_still_air(configuration)
    assert still.simulator.gust_intensity == 0.0
    assert not np.any(still.simulator.wind)
    assert still.simulator.rate_lag == configuration.simulator.rate_lag
    rates = {}
    for rate in (10.0, 15.0, 20.0, 30.0):  # commands come with every state or every second one
        tracking = replace(configuration.controller, control_rate=rate)
        rates[rate] = in_still_air(replace(configuration, controller=tracking))
    found = {rate: each.controller.control_rate for rate, each in rates.items()}
    assert found == {10.0: 10.0, 15.0: 10.0, 20.0: 20.0, 30.0: 20.0}
    log = simulate(replace(still, mission=replace(still.mission, duration=2.0)))
    assert np.abs(log.error[:, 0]).max() < 1.0  # it begins on the orbit


@pytest.mark.parametrize(
    ("estimators", "error", "share"),
    [(False, 0.01, 0.02), pytest.param(True, 0.1, 0.1, marks=pytest.mark.long)],
)
def test_model_and_flight_agree(configuration, near, estimators, error, share, monkeypatch):
    """Estimators of air and response, which the model does not know, hardly show on the orbit."""
    monkeypatch.setattr(module, "OBSERVED", 20.0)
    controller = replace(
        configuration.controller, air_estimation=estimators, response_estimation=estimators
    )
    by_model = near.loop(near.orbit_in(np.zeros(3)))
    frequency = by_model.frequencies(200)
    flights = replace(configuration, controller=controller)
    (flown,) = flown_loops(flights, frequency, workers=1, show=False)
    assert flown.settled
    expected = sensitivities(by_model.response(frequency))
    np.testing.assert_allclose(sensitivities(flown.loop), expected, atol=error)
    found = loop_margins(frequency, flown.loop)
    told = loop_margins(frequency, by_model.response(frequency))
    assert found.disk == pytest.approx(told.disk, rel=share)
    for name, channel in found.channels.items():
        assert channel.delay_s == pytest.approx(told.channels[name].delay_s, rel=share)
        assert channel.phase_deg == pytest.approx(told.channels[name].phase_deg, rel=share)


def left_of_an_answer(configuration, axis, **simulator):
    """Greatest command in the last 10 s over that in the 10 s after an impulse.

    Infinite where the loop swung so that it was softened. The controller does not learn of the
    response: that is another remedy than a margin.
    """
    still = in_still_air(configuration)
    still = replace(
        still,
        simulator=replace(still.simulator, **simulator),
        controller=replace(still.controller, response_estimation=False),
    )
    inputs = 0.3 * np.diag(module.IMPULSES)[axis]
    log = simulate(still, disturbance=partial(disturbed, inputs, 0.05))
    if log.softened > 1.0:
        return np.inf
    answer = np.abs(log.inputs[:, axis] - np.median(log.inputs[:, axis]))
    first = (log.command_time > 10.0) & (log.command_time < 20.0)
    return answer[log.command_time > 40.0].max() / answer[first].max()


@pytest.mark.parametrize(
    ("axis", "share", "least", "most"),
    [
        pytest.param(1, 0.85, 0.0, 0.5, marks=pytest.mark.long),
        pytest.param(1, 1.15, 1.5, np.inf, marks=pytest.mark.long),
        (0, 0.85, 0.0, 0.01),
        (0, 1.15, 0.5, np.inf),
    ],
)
def test_a_flight_bears_the_delay_and_gain_that_are_told_and_no_more(
    configuration, margins, axis, share, least, most
):
    dead_time, gain = np.array(configuration.simulator.dead_time), np.ones(3)
    if axis == 1:
        dead_time[1] += share * margins.channels["path"].delay_s
    else:
        gain[0] = 10.0 ** (share * margins.channels["turn"].gain_increase_db / 20.0)
    changes = {"dead_time": tuple(dead_time), "command_gain": tuple(gain)}
    assert least <= left_of_an_answer(configuration, axis, **changes) <= most


def modelled(settled=True):
    def flown_loops(configuration, frequency, sizes, workers, show):
        near = OrbitLoop(configuration.controller)
        loop = near.loop(near.orbit_in(np.zeros(3))).response(frequency)
        return [FlownLoop(loop, settled) for _ in sizes]

    return flown_loops


def bent(straight_below):
    """A loop that answers impulses above a size in another way, by half as much again for each."""

    def flown_loops(configuration, frequency, sizes, workers, show):
        (one,) = modelled()(configuration, frequency, sizes[:1], workers, show)
        shares = [1.0 if size < straight_below else 1.0 + size for size in sizes]
        return [FlownLoop(share * one.loop, True) for share in shares]

    return flown_loops


def test_impulses_are_made_smaller_until_the_answer_is_linear(configuration, near, monkeypatch):
    monkeypatch.setattr(module, "flown_loops", bent(straight_below=0.6))
    by_model = near.loop(near.orbit_in(np.zeros(3)))
    frequency = by_model.frequencies(100)
    flown, difference = module.linear_loop(configuration, frequency, 1, False)
    np.testing.assert_array_equal(flown.loop, by_model.response(frequency))
    assert difference == 0.0


def test_a_loop_that_is_not_linear_however_small_the_impulse_is_refused(
    configuration, near, monkeypatch
):
    monkeypatch.setattr(module, "flown_loops", bent(straight_below=0.2))
    frequency = near.loop(near.orbit_in(np.zeros(3))).frequencies(100)
    with pytest.raises(ParameterError, match="impulses of 0.25 and 0.125 of the usual size"):
        module.linear_loop(configuration, frequency, 1, False)


@pytest.fixture(scope="module")
def study():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(module, "flown_loops", modelled())
        patch.setattr(module, "AZIMUTHS", 4)
        return margin_study(load_configuration("small_uav", scenario="crosswind"))


def test_the_contract(study):
    content = json.loads(json.dumps(as_json(study), allow_nan=False))
    for name in ("turn", "path", "speed"):
        channel = content["channels"][name]
        assert channel["delay_s"] >= 0.3
        assert channel["gain_db"] >= 6.0
        assert 0.0 < channel["phase_deg"] <= 180.0
        assert content["wind"]["channels"][name]["delay_s"] >= 0.3
    assert 0.0 < content["disk"] < 2.0
    assert content["config"] == "small_uav"
    assert content["shortfalls"] == []


def test_the_worst_of_the_orbit_in_the_drift_of_wind_and_target(study):
    np.testing.assert_allclose(study.drift, [-5.0, 8.0, 0.0])
    disks = [each.disk for each in study.in_wind]
    assert len(disks) == 4
    assert study.worst.disk == min(disks)
    worst = as_json(study)["wind"]["worst_phase_deg"]
    assert worst == pytest.approx(math.degrees(study.azimuths[int(np.argmin(disks))]))


def test_the_table_has_a_row_for_each_and_the_figure_is_drawn(study):
    found = study_of(study)
    text = found.tables["margins"].as_markdown()
    assert text.count("| turn |") == text.count("| all |") == 3
    figure = found.figures["margins"]()
    chart, around = figure.axes
    assert len(chart.lines) >= 7
    assert len(around.lines) >= 7
    assert png(figure)[:4] == b"\x89PNG"


def test_answers_that_do_not_die_away_have_no_margin(monkeypatch):
    monkeypatch.setattr(module, "flown_loops", modelled(settled=False))
    found = margin_study(load_configuration("small_uav"))
    assert found.flown is UNSTABLE
    content = as_json(found)
    assert content["wind"] is None  # in still air
    assert content["channels"]["turn"]["gain_db"] == 0.0
    assert content["channels"]["turn"]["crossover_rad_s"] is None
    assert len(content["shortfalls"]) == 6
    assert png(study_of(found).figures["margins"]())
