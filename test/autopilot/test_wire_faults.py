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

"""What arrives of what was sent, fault by fault."""

import inspect
import itertools

import pytest

from uav_tracking_mpc.autopilot import wire_faults
from uav_tracking_mpc.autopilot.deliveries import StreamRule
from uav_tracking_mpc.autopilot.wire_faults import STRANGER, WIRE_FAULTS, wire_fault
from uav_tracking_mpc.links.mavlink.dialect import mavlink
from uav_tracking_mpc.parameters.specification import ParameterError

PIECES = [bytes([number % 256]) * 30 for number in range(400)]


class Autopilot:
    def __init__(self):
        self.restarts, self.clock = 0, 0.0

    def restart(self):
        self.restarts += 1

    def jump_clock(self, seconds):
        self.clock += seconds


def delivered(name, outward=True, seed=1, pieces=PIECES):
    fault = wire_fault(name, seed)
    return [fault.deliver(outward, piece) for piece in pieces]


def data(deliveries):
    return [piece for pieces in deliveries for _, piece in pieces]


def test_at_least_twelve_are_found_by_name():
    assert len(WIRE_FAULTS) >= 12
    kinds = [kind for _, kind in inspect.getmembers(wire_faults, inspect.isclass)]
    fitting = {kind for kind in kinds if issubclass(kind, StreamRule) and hasattr(kind, "name")}
    assert set(WIRE_FAULTS.values()) == fitting
    with pytest.raises(ParameterError, match="fault is 'sunspots', must be one of bit_flips"):
        wire_fault("sunspots")


@pytest.mark.parametrize("name", sorted(set(WIRE_FAULTS) - {"bursts", "stale"}))  # by the clock
def test_a_seed_makes_it_the_same_again(name):
    assert delivered(name, seed=3) == delivered(name, seed=3)


@pytest.mark.parametrize(
    ("name", "share"), [("loss", 0.7), ("silence", 0.0), ("restart", 0.0), ("duplicated", 3.0)]
)
def test_some_of_it_is_lost_or_comes_three_times(name, share):
    assert len(data(delivered(name))) / len(PIECES) == pytest.approx(share, abs=0.08)


def test_one_way_alone():
    assert (data(delivered("mute", True)), data(delivered("mute", False))) == ([], PIECES)
    assert (data(delivered("deaf", True)), data(delivered("deaf", False))) == (PIECES, [])


def test_bursts_of_silence_come_and_go():
    fault = wire_fault("bursts", 1)
    heard = []
    for tick in range(1000):
        fault.now = 100.0 + 0.02 * tick
        heard.append(bool(fault.deliver(True, b"x")))
    assert 0.3 < sum(heard) / len(heard) < 0.7
    changes = sum(one != other for one, other in itertools.pairwise(heard))
    assert 20 < changes < 60


def test_late_but_whole():
    for name, latest in {"latency": 0.4, "jitter": 0.2, "reordered": 0.3}.items():
        deliveries = delivered(name)
        assert data(deliveries) == PIECES
        delays = [delay for pieces in deliveries for delay, _ in pieces]
        assert max(delays) == pytest.approx(latest, abs=0.01)
        assert (min(delays) < 0.05) == (name != "latency")


def test_what_is_old_comes_again_the_same_way():
    fault = wire_fault("stale")
    for index, piece in enumerate(PIECES):
        fault.now = 100.0 + 0.02 * index
        arrived = [heard for _, heard in fault.deliver(True, piece)]
        assert arrived[0] == piece
        if index > 155:
            (_, old) = arrived
            assert old in PIECES[: index - 140]
    assert len(fault.deliver(False, b"x")) == 1  # not what went the other way


def test_bytes_are_changed():
    flipped = data(delivered("bit_flips"))
    changed = [
        bin(int.from_bytes(one, "big") ^ int.from_bytes(other, "big")).count("1")
        for one, other in zip(PIECES, flipped, strict=True)
    ]
    assert 0.15 < sum(count > 0 for count in changed) / len(PIECES) < 0.45
    assert max(changed) <= 4
    cut = data(delivered("truncated"))
    assert 0.5 < sum(len(piece) == 30 for piece in cut) / len(PIECES) < 0.9
    noisy = data(delivered("garbage"))
    assert [piece for piece in noisy if piece in PIECES][:400] == PIECES
    assert len(noisy) > 450


def test_another_vehicle_is_heard_beside_it():
    heard = [piece for piece in data(delivered("stranger")) if piece not in PIECES]
    messages = mavlink.MAVLink(None).parse_buffer(b"".join(heard))
    assert {message.get_srcSystem() for message in messages} == {STRANGER}
    assert {"HEARTBEAT", "GLOBAL_POSITION_INT"} <= {message.get_type() for message in messages}
    assert data(delivered("stranger", outward=False)) == PIECES


def test_some_act_on_the_autopilot_itself():
    autopilot = Autopilot()
    fault = wire_fault("clock_jump", 5)
    fault.begin(autopilot)
    assert abs(autopilot.clock) >= 0.5
    fault.end(autopilot)
    wire_fault("restart").begin(autopilot)
    assert (autopilot.clock, autopilot.restarts) == (0.0, 1)
