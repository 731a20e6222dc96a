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

"""Margins of loops that are known in closed form, and those that python-control finds."""

import math

import numpy as np
import pytest

from uav_tracking_mpc.margins import loop_margins as lm

FREQUENCY = np.geomspace(1e-3, 1e2, 2000)
S = 1j * FREQUENCY


def diagonal(*ratios):
    loop = np.zeros((len(FREQUENCY), 3, 3), dtype=complex)
    for axis, ratio in enumerate(ratios):
        loop[:, axis, axis] = ratio
    return loop


def test_integrator_with_dead_time():
    """l = k e^(-s theta) / s: |l| = 1 at k, phase -pi/2 - k theta; real at pi / (2 theta)."""
    k, theta = 2.0, 0.3
    found = lm.channel_margins(FREQUENCY, k / S * np.exp(-S * theta))
    lag = math.pi / 2.0 - k * theta
    assert found.delay_s == pytest.approx(lag / k, rel=1e-3)
    assert found.phase_deg == pytest.approx(math.degrees(lag), rel=1e-3)
    assert found.crossover_rad_s == pytest.approx(k, rel=1e-3)
    assert found.gain_db == pytest.approx(20.0 * math.log10(math.pi / (2.0 * theta * k)), rel=1e-3)
    assert found.gain_db == found.gain_increase_db
    assert found.gain_reduction_db == math.inf


def test_a_conditionally_stable_loop_has_a_gain_reduction():
    """l = k / (s - 1) is stable for k > 1 alone."""
    ratio = 4.0 / (S - 1.0) * np.exp(-0.01 * S)
    # l(0) = -4 lies on the axis only where the frequencies end
    assert lm.channel_margins(FREQUENCY, ratio).gain_reduction_db == math.inf
    below = lm.channel_margins(np.append(0.0, FREQUENCY), np.append(-4.0, ratio))
    assert below.gain_db == below.gain_reduction_db == pytest.approx(20.0 * math.log10(4.0))


def test_a_small_loop_bears_any_delay():
    found = lm.channel_margins(FREQUENCY, 0.5 / (S + 1.0))
    assert found.delay_s == found.phase_deg == math.inf
    assert math.isnan(found.crossover_rad_s)


def test_a_channel_agrees_with_python_control():
    control = pytest.importorskip("control", "0.10.2")
    loop = control.tf([3.0], [0.1, 1.0, 0.5, 0.0])
    found = lm.channel_margins(FREQUENCY, np.squeeze(loop(S)))
    gain, phase, _, _, crossover, _ = control.stability_margins(loop)
    disk, disk_gain, disk_phase = control.disk_margins(loop, FREQUENCY)
    figures = (found.phase_deg, found.crossover_rad_s, found.disk)
    assert figures == pytest.approx((phase, crossover, disk), rel=1e-3)
    assert found.gain_increase_db == pytest.approx(20.0 * math.log10(gain), rel=1e-3)
    inside = (lm.disk_gain_db(disk), lm.disk_phase_deg(disk))
    assert inside == pytest.approx((disk_gain, disk_phase), rel=1e-6)


def test_all_at_once_without_coupling_is_the_worst_channel():
    ratios = [2.0 / S * np.exp(-0.2 * S), 1.0 / S, 1.0 / (S * (S + 1.0))]
    found = lm.loop_margins(FREQUENCY, diagonal(*ratios))
    disks = [lm.channel_margins(FREQUENCY, ratio).disk for ratio in ratios]
    assert [each.disk for each in found.channels.values()] == pytest.approx(disks)
    assert found.disk == pytest.approx(min(disks), rel=1e-4)


def coupled(strength):
    ratio = 2.0 / S * np.exp(-0.2 * S)
    loop = diagonal(ratio, ratio, 1.0 / (S * (S + 1.0)))
    loop[:, 0, 1], loop[:, 1, 0] = strength * ratio, -strength * ratio
    return loop


def test_units_of_the_channels_do_not_matter():
    scale = np.array([1.0, 0.01, 300.0])
    loop = coupled(0.7)
    expected = lm.loop_margins(FREQUENCY, loop)
    found = lm.loop_margins(FREQUENCY, scale[:, np.newaxis] * loop / scale)
    assert found.disk == pytest.approx(expected.disk, rel=1e-3)


def test_some_perturbation_of_the_size_of_the_disk_and_none_smaller_destabilises():
    """At the worst frequency I + L (1 + delta/2) / (1 - delta/2) becomes singular."""
    loop = coupled(0.7)
    disk = lm.loop_margins(FREQUENCY, loop).disk
    assert disk < min(each.disk for each in lm.loop_margins(FREQUENCY, loop).channels.values())
    sensitivity = np.linalg.inv(np.eye(3) + loop) - 0.5 * np.eye(3)
    generator = np.random.default_rng(1)
    angles = generator.uniform(0.0, 2.0 * np.pi, (400, 3))
    # The spectral radius of (S - I/2) Delta is below mu, and comes near it for the best Delta.
    radius = max(
        np.abs(np.linalg.eigvals(sensitivity[::20] * np.exp(1j * each))).max() for each in angles
    )
    assert 0.97 / disk < radius <= 1.001 / disk
