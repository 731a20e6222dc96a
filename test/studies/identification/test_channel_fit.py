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

"""Lag, dead time and gain are found again."""

import numpy as np
import pytest
from excited_channel import record
from scipy.signal import lfilter

from uav_tracking_mpc.studies.identification.channel_fit import ChannelFit
from uav_tracking_mpc.studies.identification.channel_record import ChannelRecord, Samples


def fitted(channel):
    return ChannelFit(channel, channel.demand.value).run()


@pytest.mark.parametrize(("lag", "dead_time"), [(0.0, 0.0), (0.05, 0.31), (0.3, 0.0), (1.0, 0.17)])
def test_without_noise_the_truth_is_found(lag, dead_time):
    fit = fitted(record(lag, dead_time, 0.9, noise=0.0))
    assert fit.lag == pytest.approx(lag, abs=2e-3)
    assert fit.dead_time == pytest.approx(dead_time, abs=2e-3)
    assert fit.solved.gain == pytest.approx(0.9, abs=2e-3)
    np.testing.assert_allclose(fit.fitted(), fit.record.state.value, atol=1e-2)


def test_a_measured_rate_tells_more_although_it_is_biased():
    exact = record(0.2, 0.1, rate_noise=0.02)
    assert exact.rate is not None
    biased = ChannelRecord(
        exact.name,
        exact.demand,
        exact.state,
        Samples(exact.rate.time, exact.rate.value + 0.5),
        exact.leverage,
    )
    fit = fitted(biased)
    assert fit.lag == pytest.approx(0.2, abs=5e-3)
    assert fit.dead_time == pytest.approx(0.1, abs=5e-3)


def test_a_drift_of_the_state_is_no_response():
    """A constant wind of the airspeed, or a bias of the rate that is integrated."""
    still = record(0.3, 0.1, noise=0.01)
    time, value = still.state
    drifting = ChannelRecord(
        still.name, still.demand, Samples(time, value + 0.2 * time + 7.0), None, still.leverage
    )
    assert fitted(drifting).lag == pytest.approx(fitted(still).lag, abs=1e-3)


def test_coloured_noise_is_recognised():
    still = record(0.3, 0.1, noise=0.0)
    drawn = 0.03 * np.random.default_rng(5).standard_normal(len(still.state.time))
    gusts = lfilter([1.0], [1.0, -0.98], drawn)
    time, value = still.state
    gusty = ChannelRecord(
        still.name, still.demand, Samples(time, value + gusts), None, still.leverage
    )
    fit = fitted(gusty)
    assert len(fit.noise[0].polynomial) > 1
    assert fit.lag + fit.dead_time == pytest.approx(0.4, abs=0.03)  # two standard deviations


def test_a_record_that_is_too_short_is_refused():
    channel = record(0.3, 0.1)
    with pytest.raises(ValueError, match="must be at least 10 s"):
        ChannelRecord.of(
            channel.name,
            channel.demand,
            Samples(channel.state.time[:150], channel.state.value[:150]),
            None,
            channel.leverage,
        )
