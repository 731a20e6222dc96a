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

"""What parts that steer share: a folder, requests, and a line that says how they were answered."""

from __future__ import annotations

import html
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, ClassVar

from uav_tracking_mpc.view.panel import PanelPart
from uav_tracking_mpc.view.panel._html import ALARM, badge, block, faint
from uav_tracking_mpc.view.panel._requests import requests_of
from uav_tracking_mpc.view.steering import Steering
from uav_tracking_mpc.view.watched_flight import FlightSource, WatchedFlight

if TYPE_CHECKING:
    import viser

LAST = 1e6  # the line of words stands below all widgets


class SteeringPart(PanelPart):
    """A folder with widgets that make requests.

    Attributes:
        title: Of its folder.
        node: That must be there to be steered; empty for any.
        asking: Whether a request is under way.
        client: Browser that asked last; None before the first request.
    """

    title: ClassVar[str]
    node: ClassVar[str] = ""
    client: viser.ClientHandle | None

    @classmethod
    def fits(cls, flight: WatchedFlight, source: FlightSource) -> bool:
        """Whether the flight can be steered so.

        Args:
            flight: What is steered.
            source: Where it comes from.
        """
        return flight.steering is not None and (not cls.node or cls.node in flight.steering.nodes)

    @property
    def steering(self) -> Steering:
        """Of the aircraft."""
        steering = self.flight.steering
        assert steering is not None, "there is no such part without it"
        return steering

    def add(self) -> None:
        """Add the folder and the line of words."""
        self.requests = requests_of(self.steering)
        self.asking, self.client = False, None
        self._buttons: list[viser.GuiButtonHandle] = []
        self.folder = self.gui.add_folder(self.title)
        with self.folder:
            self._line = self.gui.add_html("", order=LAST, visible=False)

    def say(self, words: str, of: str = "") -> None:
        """Write the line of words.

        Args:
            words: As they are; nothing is shown where they are empty.
            of: What kind of words they are, to stand before them on a colour.
        """
        self._line.content = block(
            badge(of, ALARM) + " " + html.escape(words) if of else faint(words)
        )
        self._line.visible = bool(words)

    def add_button(
        self,
        label: str,
        request: Callable[[], str],
        hint: str = "",
        begun: Callable[[], None] | None = None,
    ) -> None:
        """Add a button that makes a request; it is disabled while one is under way.

        Args:
            label: On it.
            request: Answers why it was refused, or nothing.
            hint: What it does, in words.
            begun: Called when the request was done and not refused.
        """
        button = self.gui.add_button(label, hint=hint or None, color="orange")
        self._buttons.append(button)

        def clicked(event: viser.GuiEvent[viser.GuiButtonHandle]) -> None:
            def answered(refusal: str) -> None:
                if not refusal and begun is not None:
                    begun()

            self.client = event.client
            self.ask(label, request, answered)

        button.on_click(clicked)

    def add_buttons(self, label: str, requests: Mapping[str, Callable[[], str]], hint: str) -> None:
        """Add a row of buttons that make requests; they do nothing while one is under way.

        Args:
            label: Of the row.
            requests: Each answers why it was refused, or nothing; by the words on the button.
            hint: What they do, in words.
        """
        buttons = self.gui.add_button_group(label, tuple(requests), hint=hint)

        def clicked(event: viser.GuiEvent[viser.GuiButtonGroupHandle]) -> None:
            chosen = event.target.value
            self.client = event.client
            if chosen in requests and not self.asking:
                self.ask(chosen, requests[chosen], lambda refusal: None)

        buttons.on_click(clicked)

    def ask(self, what: str, request: Callable[[], str], then: Callable[[str], None]) -> None:
        """Make a request; buttons are disabled until it is answered.

        Args:
            what: Is asked for, in words.
            request: Answers why it was refused, or nothing.
            then: Takes the refusal, empty if there was none.
        """
        self.say(f"asking for {what} ...")
        self._rest(True)

        def answered(refusal: str) -> None:
            self._rest(False)
            self.say(refusal, of="refused" if refusal else "")
            then(refusal)

        def failed(words: str) -> None:
            self._rest(False)
            self.say(words, of="failed")
            if self.client is not None:
                self.client.add_notification(f"{what}: the request failed", words, color="red")
            then(words)

        self.requests.begin(request, answered, failed)

    def _rest(self, rest: bool) -> None:
        self.asking = rest
        for button in self._buttons:
            button.disabled = rest
