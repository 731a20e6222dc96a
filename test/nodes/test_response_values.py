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

"""/diagnostics tells of each channel what is estimated, how well, and what is flown by."""

import dataclasses

import small_uav

from uav_tracking_mpc.control.adaptation import ResponseAdaptation
from uav_tracking_mpc.control.event import EventLog
from uav_tracking_mpc.estimation.channel_response import CHANNELS, ChannelResponse
from uav_tracking_mpc.nodes.response_values import response_values


def test_estimates_with_deviations_and_what_is_flown_by():
    response = ResponseAdaptation(small_uav.parameters(), EventLog())
    response.estimator.channels[0] = ChannelResponse(
        0.31, 0.16, 0.9, 0.02, 0.03, 0.01, trusted=True
    )
    values = response_values(response)
    assert values["turn rate lag estimated [s]"] == 0.31
    assert values["turn rate lag deviation [s]"] == 0.02
    assert values["turn rate dead time deviation [s]"] == 0.03
    assert values["turn rate lag and dead time estimated [s]"] == 0.47
    assert values["turn rate gain estimated"] == 0.9
    assert values["turn rate response trusted"] is True
    assert values["acceleration response trusted"] is False
    for axis, name in enumerate(CHANNELS):
        assert values[f"{name} lag flown by [s]"] == small_uav.parameters().rate_lag[axis]
    assert values["limit cycle of the turn rate"] == "none"


def test_without_estimation_only_what_is_flown_by():
    parameters = dataclasses.replace(small_uav.parameters(), response_estimation=False)
    values = response_values(ResponseAdaptation(parameters, EventLog()))
    assert not any("estimated" in key for key in values)
    assert values["turn rate dead time flown by [s]"] == parameters.dead_time[0]
