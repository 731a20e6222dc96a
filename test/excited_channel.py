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

"""A channel that is excited, measured with noise: what the tests of identification share."""

import numpy as np

from uav_tracking_mpc.control.command_shaping import Doublets
from uav_tracking_mpc.simulation.plants.vehicle import Channel
from uav_tracking_mpc.studies.identification.flight_record import (
    SPEED,
    TURN,
    ChannelRecord,
    Samples,
)

STEP = 0.05  # s


def answer(demand, lag, dead_time, gain=1.0):
    """Rate and integral at the beginning of each step, by the simulator's inner loop."""
    channel, total, rates, integrals = Channel(lag, dead_time), 0.0, [], []
    for k, value in enumerate(demand):
        rates.append(channel.rate)
        integrals.append(total)
        now, flown = k * STEP, 0.0
        channel.command(now, gain * value)
        while flown < STEP - 1e-12:
            channel.mature(now + flown)
            until = min(channel.next_change - now, STEP)
            total += channel.integral(until - flown)
            channel.rate = channel.rate_after(until - flown)
            flown = until
    return np.array(rates), np.array(integrals)


def excitation(seed, amplitude=1.2, duration=65.0):
    time = STEP * np.arange(round(duration / STEP))
    signal = Doublets(seed)
    return time, np.array([amplitude * signal.value(t) for t in time])


def record(
    lag, dead_time, gain=1.0, noise=0.3, seed=0, rate_noise=None, name=SPEED, limit=np.inf, slow=0.0
):
    """60 s of an excited channel; its noise is white, a slow demand comes beside the doublets."""
    time, demand = excitation(seed)
    demand += slow * np.sin(0.5 * time)
    rates, integrals = answer(np.clip(gain * demand, -limit, limit), lag, dead_time)
    random = np.random.default_rng(seed)
    measured = integrals + noise * random.standard_normal(len(time))
    rate = None
    if rate_noise is not None:
        rate = Samples(time, rates + rate_noise * random.standard_normal(len(time)))
    return ChannelRecord(
        name,
        Samples(time, demand),
        Samples(time, measured),
        rate,
        np.ones(len(time)),
        banks=name == TURN,
    ).between_commands()
