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

"""What is said of a flight, and pasted from it."""

import copy
import math
from dataclasses import replace

import numpy as np
import pytest
import yaml
from excited_channel import record

from uav_tracking_mpc.settings.configuration import load_configuration
from uav_tracking_mpc.studies.identification.channel_fit import ChannelFit, Limits
from uav_tracking_mpc.studies.identification.flight_record import CHANNELS, SPEED, TURN
from uav_tracking_mpc.studies.identification.identification import (
    SHOWN,
    ChannelIdentification,
    Estimate,
    Estimates,
    identification_table,
    identify,
    parameters_to_paste,
    response_figure,
)


@pytest.fixture(scope="module")
def found():
    return identify([record(0.3, 0.1, 0.9, name=name, seed=k) for k, name in enumerate(CHANNELS)])


def pasted(found):
    return yaml.safe_load(parameters_to_paste(found))


def test_what_is_pasted_is_a_configuration(found, tmp_path):
    sections = pasted(found)
    controller = sections["/**/nmpc_controller"]["ros__parameters"]
    simulator = sections["/**/uav_simulator"]["ros__parameters"]
    assert controller["rate_lag"] == simulator["rate_lag"]
    assert controller["rate_lag"] == pytest.approx([0.3] * 3, abs=0.06)
    assert simulator["command_gain"] == pytest.approx([0.9] * 3, abs=0.05)
    text = parameters_to_paste(found)
    assert "&" not in text and "*id" not in text and "#" not in text
    overlay = tmp_path / "identified.yaml"
    overlay.write_text(text + "/**/scenario:\n  ros__parameters: {title: identified}\n")
    loaded = load_configuration("small_uav", scenario=str(overlay))
    assert list(loaded.controller.dead_time) == controller["dead_time"]


def test_limits_are_pasted_where_they_showed(found):
    turn, path, speed = found
    limited = [
        replace(turn, limits=Limits(-1.0, 2.0)),
        path,
        replace(speed, limits=Limits(upper=np.float64(1.5))),  # as the search finds them
    ]
    controller = pasted(limited)["/**/nmpc_controller"]["ros__parameters"]
    gains = [channel.estimates.gain.value for channel in found]
    assert controller["bank_max"] == pytest.approx(math.atan(gains[0]), abs=1e-3)
    assert controller["acceleration_max"] == pytest.approx(1.5 * gains[2], abs=1e-3)
    assert "acceleration_min" not in controller and "pitch_rate_max" not in controller


def test_without_an_airspeed_the_limit_of_a_turn_is_no_bank(found):
    turn = replace(found[0], limits=Limits(-0.25, 0.25))
    fit = copy.copy(turn.fit)
    fit.record = replace(turn.fit.record, banks=False)
    blind = replace(turn, fit=fit)
    assert blind.observed_limits == (None, None)
    assert blind.largest_bank is None
    assert "bank_max" not in parameters_to_paste([blind])
    assert "bank_max" in parameters_to_paste([turn])


def test_what_is_not_known_is_said(found):
    _, path, _ = found
    vague = path.estimates._replace(total=path.estimates.total._replace(lower=0.0, upper=1.0))
    text = parameters_to_paste([found[0], replace(path, estimates=vague)])
    assert "# path: not sure, excite it more" in text
    assert "# speed: not measured" in text


@pytest.mark.parametrize("gain", [Estimate(-1.0, -1.1, -0.9), Estimate(0.0, -math.inf, math.inf)])
def test_a_gain_of_a_wrong_sign_or_of_no_commands_is_not_pasted(found, gain):
    turned = replace(found[0], estimates=found[0].estimates._replace(gain=gain))
    assert pasted([turned])["/**/uav_simulator"]["ros__parameters"]["command_gain"] == [1.0] * 3
    assert (
        ("# turn: answers the wrong way round" in parameters_to_paste([turned]))
        == (not turned.as_json()["sure"])
        == (gain.upper < 0.0)
    )


def test_every_channel_has_a_row_plain_values_and_two_panels(found):
    table = identification_table(found)
    assert [row[0] for row in table.rows] == list(CHANNELS)
    assert "bank" in table.rows[0][5]
    figures = found[2].as_json()
    assert figures["lag_s"]["lower"] <= figures["lag_s"]["value"] <= figures["lag_s"]["upper"]
    assert figures["limits_observed"] == [None, None]
    assert np.isfinite([*figures["largest"], figures["noise"]]).all()
    assert len(response_figure(found).axes) == 2 * len(CHANNELS)


LAG, DEAD_TIME = 0.3, 0.1
UNITS = {TURN: ("[deg/s]", "[deg]"), SPEED: ("[m/s²]", "[m/s]")}


def known(name):
    """A channel without noise, of which the truth is known."""
    channel = record(LAG, DEAD_TIME, noise=0.0, rate_noise=0.0, name=name)
    fit = ChannelFit(channel, channel.demand.value)
    fit.lag, fit.dead_time, fit.solved = LAG, DEAD_TIME, fit.solve(LAG, DEAD_TIME)
    truth = Estimates(*(Estimate(v, v, v) for v in (LAG, DEAD_TIME, LAG + DEAD_TIME, 1.0)))
    return ChannelIdentification(name, truth, fit, Limits())


def test_each_row_shows_its_channel_over_the_last_seconds():
    """What the inner loop flew is measured; with the truth what is fitted lies on it."""
    found = [known(name) for name in UNITS]
    rows = np.reshape(response_figure(found).axes, (-1, 2))
    for channel, (rates, states) in zip(found, rows, strict=True):
        assert (rates.get_ylabel(), states.get_ylabel()) == UNITS[channel.name]
        flown = channel.fit.record.rate
        late = flown.time >= flown.time[-1] - SHOWN
        value = flown.value[late] * (1.0 if channel.name == SPEED else 180.0 / np.pi)
        lines = {line.get_label(): line for axes in (rates, states) for line in axes.lines}
        for label in ("_measured", "fitted rate"):
            np.testing.assert_array_equal(lines[label].get_xdata(), flown.time[late])
            np.testing.assert_allclose(lines[label].get_ydata(), value, atol=1e-3 * np.ptp(value))
        measured, fitted = lines["measured"].get_ydata(), lines["fitted"].get_ydata()
        np.testing.assert_allclose(measured, fitted, atol=1e-3 * np.ptp(fitted))
        end = flown.time[-1]
        assert rates.get_xlim() == states.get_xlim() == pytest.approx((end - SHOWN, end))
