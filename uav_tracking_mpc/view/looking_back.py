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

"""Pages that look at the past: each has a scene of its own, of its own time."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import viser

from uav_tracking_mpc.settings.tracking import TrackingParameters
from uav_tracking_mpc.view.flight_history import FlightHistory
from uav_tracking_mpc.view.watched_flight import Sight, WatchedFlight

PAST_WORLD = "/past"  # node under which the scene of a past time hangs

Watched = tuple[WatchedFlight, Sight]
Show = Callable[[Sight], None]
DrawnBy = Callable[[viser.SceneApi, str, WatchedFlight], Show]


class PastFlight(WatchedFlight):
    """A flight as it was; it cannot be steered.

    Args:
        flight: That goes on.
        history: Of it.
    """

    def __init__(self, flight: WatchedFlight, history: FlightHistory) -> None:
        self.name, self._flight, self._history = flight.name, flight, history
        self._sight: Sight | None = None

    @property
    def sight(self) -> Sight | None:
        """What there was to see at the time that was gone to last."""
        return self._sight

    @property
    def tracking(self) -> TrackingParameters | None:  # type: ignore[override]  # only read
        """What its controller flies by now."""
        return self._flight.tracking

    def go_to(self, time: float) -> Sight | None:
        """Show a time.

        Args:
            time: Of the flight's clock in [s].

        Returns:
            What there was to see; None where nothing is known.
        """
        self._sight = self._history.at(time)
        return self._sight

    def past(self, span: float) -> Sequence[Sight]:
        """See :meth:`WatchedFlight.past`.

        Args:
            span: How far back from the shown time in [s].
        """
        if self._sight is None:
            return []
        return self._history.between(self._sight.time - span, self._sight.time)


class LookingBack:
    """The past as one page sees it, in place of the scene that all pages share.

    Args:
        client: The page.
        world: Name of the node under which the shared scene hangs.
        draw: Begins to draw an aircraft: of a scene, the name of a node and a flight; answers what
            draws each of its sights.
    """

    def __init__(self, client: viser.ClientHandle, world: str, draw: DrawnBy) -> None:
        self._client, self._world, self._draw = client, world, draw
        self.frame = client.scene.add_frame(PAST_WORLD, show_axes=False, visible=False)
        self._drawn: dict[str, tuple[PastFlight, Show]] = {}
        self._time: float | None = None
        self.watched: dict[str, Watched] = {}

    def show(
        self, time: float | None, flights: Mapping[str, tuple[WatchedFlight, FlightHistory]]
    ) -> None:
        """Show a past time, or the shared scene again.

        Args:
            time: Of the flights' clock in [s]; None for now.
            flights: All aircraft by name.
        """
        if time == self._time:
            return
        self._time = time
        shared = self._client.scene.get_handle_by_name(self._world)
        with self._client.atomic():
            self.watched = {} if time is None else self._at(time, flights)
            self.frame.visible = bool(self.watched)
            if shared is not None:
                shared.visible = not self.watched

    def _at(
        self, time: float, flights: Mapping[str, tuple[WatchedFlight, FlightHistory]]
    ) -> dict[str, Watched]:
        watched: dict[str, Watched] = {}
        for name, (flight, history) in flights.items():
            if name not in self._drawn:
                past = PastFlight(flight, history)
                show = self._draw(self._client.scene, f"{PAST_WORLD}/{name}", past)
                self._drawn[name] = past, show
            past, show = self._drawn[name]
            sight = past.go_to(time)
            if sight is not None:
                show(sight)
                watched[name] = past, sight
        return watched
