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

"""Simulated flights with lags drawn at random, and what is found of them."""

import numpy as np
import pytest

from uav_tracking_mpc.studies.identification import validation
from uav_tracking_mpc.studies.identification.flight_record import CHANNELS
from uav_tracking_mpc.studies.identification.identification import Estimates
from uav_tracking_mpc.studies.identification.validation import (
    DEAD_TIME,
    GAIN,
    LAG,
    NEAR,
    TOLD,
    drawn,
    validate,
)

ONE = {"truth": 1.0, "value": 1.0, "lower": 0.5, "upper": 1.5}
QUICK = ("nmpc_controller.law=l1",)  # needs no solver


def test_what_is_drawn_depends_on_the_seed_alone():
    one, other, another = (drawn("small_uav", (), seed) for seed in (3, 3, 4))
    np.testing.assert_equal(one[1], other[1])
    assert one[0].controller == other[0].controller
    assert np.all(another[1]["lag"] != one[1]["lag"])


@pytest.mark.parametrize("seed", range(3))
def test_what_is_drawn_is_flown_and_told_wrong(seed):
    configuration, truth = drawn("small_uav", (), seed)
    simulator, controller = configuration.simulator, configuration.controller
    np.testing.assert_array_equal(simulator.rate_lag, truth["lag"])
    np.testing.assert_array_equal(simulator.dead_time, truth["dead_time"])
    np.testing.assert_array_equal(simulator.command_gain, truth["gain"])
    np.testing.assert_array_equal(truth["total"], truth["lag"] + truth["dead_time"])
    for figure, (least, most) in {"lag": LAG, "dead_time": DEAD_TIME, "gain": GAIN}.items():
        assert least <= min(truth[figure]) and max(truth[figure]) <= most
    wrong = np.array(controller.rate_lag) / truth["lag"]
    assert np.all((wrong >= 1.0 / TOLD) & (wrong <= TOLD)) and not np.allclose(wrong, 1.0)
    assert any(controller.excitation)


def test_flights_are_counted(monkeypatch):
    monkeypatch.setattr(validation, "DURATION", 45.0)
    monkeypatch.setattr(validation, "EXCITED", 25.0)
    study = validate("small_uav", QUICK, count=1, seed=1, workers=1)
    content = study.content
    assert list(content["channels"]) == list(CHANNELS)
    for channel in content["channels"].values():
        (errors,) = channel["errors"]
        for figure, (least, share) in NEAR.items():
            truth, value = errors[figure]["truth"], errors[figure]["value"]
            near = abs(value - truth) <= max(least, share * truth)
            assert channel["near"][figure] == near
            held = errors[figure]["lower"] <= truth <= errors[figure]["upper"]
            assert channel["covered"][figure] == held
    assert len(study.tables["identification"].rows) == len(CHANNELS)


def test_what_was_flown_before_an_interruption_is_counted(monkeypatch):
    row = {name: dict.fromkeys(Estimates._fields, ONE) for name in CHANNELS}

    def interrupted(config, overrides, seed):
        if seed == 2:
            raise KeyboardInterrupt
        return row

    monkeypatch.setattr(validation, "fly", interrupted)
    study = validate("small_uav", count=4, workers=1)
    assert study.left == "2 of 4 flights were flown"
    assert study.content["flights"] == len(study.content["channels"]["turn"]["errors"]) == 2


@pytest.mark.long
def test_most_flights_are_identified():
    """Of 8 flights at 95 %, fewer than 6 are a chance of 1 in 175."""
    content = validate("small_uav", count=8).content
    for channel in content["channels"].values():
        assert min(channel["near"].values()) >= 0.75
        assert min(channel["covered"].values()) >= 0.75
