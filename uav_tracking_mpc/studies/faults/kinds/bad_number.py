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

"""A number that is no number, infinite or huge."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from uav_tracking_mpc.nodes.topics import Topic
from uav_tracking_mpc.studies.faults.kinds import Fault
from uav_tracking_mpc.studies.faults.message_fields import numbers
from uav_tracking_mpc.studies.faults.stream_fault import MessageFault

VALUES = {"nan": math.nan, "inf": math.inf, "huge": 1e300}


class BadNumber(MessageFault):
    """Replaces one number of a message, of either sign.

    Args:
        topic: That it strikes.
        word: Which of the values.
    """

    name = "bad_number"

    def __init__(self, topic: Topic, word: str) -> None:
        super().__init__(topic)
        self._word = word

    @classmethod
    def variants(cls) -> Sequence[Fault]:
        """Every value on every topic."""
        return [cls(topic, word) for topic in cls.topics for word in VALUES]

    @property
    def label(self) -> str:
        """Such as ``odometry_nan``."""
        return f"{self.family}_{self._word}"

    def change(self, topic: Topic, message: Any) -> None:
        """See :meth:`MessageFault.change`."""
        fields = numbers(topic, message)
        if fields:
            holder, name = self.rng.choice(fields)
            setattr(holder, name, self.rng.choice((1.0, -1.0)) * VALUES[self._word])
