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

"""Whether a fault keeps what :class:`Fault` asks for."""

from __future__ import annotations

import math
import random

from rclpy.serialization import deserialize_message, serialize_message

from uav_tracking_mpc.parameters.conformance import judged, require, require_name
from uav_tracking_mpc.studies.faults.kinds import Fault
from uav_tracking_mpc.studies.faults.stream_fault import STREAMS, StreamFault

COUNT = 50  # messages of each topic
REACH = 300.0  # m


def check_fault(fault: type[Fault]) -> None:
    """Look at every variant of a fault, and give messages to those that strike messages.

    What a fault does to processes is seen in a campaign alone. Needs rclpy.

    Args:
        fault: Class of the fault.

    Raises:
        ConformanceError: It raises, says not what it is, delivers what is no message of its topic,
            or does not deliver the same to the same seed.
    """
    name = require_name(fault)
    with judged(name):
        variants, again = list(fault.variants()), list(fault.variants())
        labels = [variant.label for variant in variants]
        require(variants, f"{name}: it has no variants")
        require(len(set(labels)) == len(labels), f"{name}: two variants are called alike: {labels}")
        for variant, other in zip(variants, again, strict=True):
            _check(variant, other)


def _check(fault: Fault, again: Fault) -> None:
    family, (shortest, longest) = getattr(fault, "family", ""), fault.duration
    require(isinstance(family, str) and family, f"{fault.label}: it has no `family`")
    words = f"{fault.label}: its duration is {fault.duration}, must be shortest and longest in s"
    require(0.0 <= shortest <= longest, words)
    if isinstance(fault, StreamFault) and isinstance(again, StreamFault):
        names = [topic.name for topic in STREAMS]
        words = f"{fault.label}: its streams must be some of {', '.join(names)}"
        require(fault.streams and set(fault.streams) <= set(STREAMS), words)
        delivered = [_delivered(each) for each in (fault, again)]
        words = f"{fault.label}: the same seed delivers other messages; draw from self.rng alone"
        require(delivered[0] == delivered[1], words)


def _delivered(fault: StreamFault) -> list[tuple[float, str]]:
    """What arrives of some messages of each topic."""
    fault.prepare(random.Random(0), REACH)
    arrived = []
    for topic in fault.streams:
        for k in range(COUNT):
            fault.now = 0.05 * k
            for delay, message in fault.deliver(topic, serialize_message(topic.type())):
                words = f"{fault.label}: a message of {topic.name} is {delay!r} s late"
                require(math.isfinite(delay) and delay >= 0.0, words)
                arrived.append((delay, repr(deserialize_message(message, topic.type))))
    return arrived
