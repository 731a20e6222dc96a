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

"""One aircraft that a page shows, and where such aircraft come from."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence

from uav_tracking_mpc.settings.tracking import TrackingParameters
from uav_tracking_mpc.view.play_clock import PlayClock
from uav_tracking_mpc.view.sight import Sight
from uav_tracking_mpc.view.steering import Steering


class WatchedFlight(ABC):
    """One aircraft.

    Attributes:
        name: Its namespace without slashes, or what was flown; one word, its own in a source.
        steering: None where nothing can be steered.
    """

    name: str
    steering: Steering | None = None

    @property
    @abstractmethod
    def sight(self) -> Sight | None:
        """What there is to see now; None before the first state."""

    @property
    @abstractmethod
    def tracking(self) -> TrackingParameters | None:
        """What its controller flies by, with its limits; None before that is known."""

    @abstractmethod
    def past(self, span: float) -> Sequence[Sight]:
        """What there was to see, oldest first, a few a second: for tracks and plots.

        Args:
            span: How far back from now in [s].
        """


class FlightSource(ABC):
    """Aircraft that are flown or were.

    Attributes:
        clock: Of a record; None where the flight is flown now.
    """

    clock: PlayClock | None = None

    @property
    def words(self) -> str:
        """What people read while there is nothing to see, such as what is waited for."""
        return ""

    @abstractmethod
    def flights(self) -> Sequence[WatchedFlight]:
        """All that are known now; the same objects each time."""

    @abstractmethod
    def close(self) -> None:
        """Let go of what the source holds."""
