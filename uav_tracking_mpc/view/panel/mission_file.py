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

"""The mission as a file or a link: how wind, target and orbit are steered, to fly it again."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any
from urllib.parse import quote

import viser

from uav_tracking_mpc.parameters.specification import ParameterError, specifications
from uav_tracking_mpc.settings.configuration import (
    SCENARIO,
    SECTIONS,
    parameter_file,
    read_sections,
)
from uav_tracking_mpc.simulation.plants import PACE
from uav_tracking_mpc.view.panel import FOLDED, PanelPart
from uav_tracking_mpc.view.panel._html import block
from uav_tracking_mpc.view.panel._steering_part import requests_of
from uav_tracking_mpc.view.simulated_steering import ORBIT
from uav_tracking_mpc.view.watched_flight import (
    CONTROLLER,
    SIMULATOR,
    TARGET,
    FlightSource,
    Steering,
    WatchedFlight,
)

FILE = "mission.yaml"
# Without the token: whoever opens it needs a page of his own, as for everything else.
LINK = (
    '<a href="/#mission={}" onclick="if (navigator.clipboard) {{'
    "navigator.clipboard.writeText(this.href); event.preventDefault();"
    " this.textContent = 'The link is copied'}}\">Link to this mission: a click copies it</a>"
)


def mission_of(steering: Steering, name: str) -> str:
    """A scenario file: how wind, target and orbit are now.

    Args:
        steering: Of the flight.
        name: Of the flight.
    """
    sections: dict[str, dict[str, Any]] = {
        SCENARIO: {"title": name, "description": "As it was steered on the page."}
    }
    for node in (SIMULATOR, TARGET, CONTROLLER):
        if node in steering.nodes:
            values = steering.parameters(node)
            kept = {key: values[key] for key in _steered(node) if key in values}
            sections[node] = {key: _plain(value) for key, value in kept.items()}
    return parameter_file(sections)


def fly_mission(steering: Steering, content: bytes) -> str:
    """Steer a flight as a scenario file says.

    Args:
        steering: Of the flight.
        content: Of the file.

    Returns:
        What was refused, and why, and what is flown nevertheless; empty where all was done.
    """
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / FILE
        path.write_bytes(content)
        try:
            sections = read_sections(path, [*SECTIONS, SCENARIO])
        except ParameterError as error:
            return str(error).replace(f" {path}", "")
    refusals: list[str] = []
    flown: list[str] = []
    for node in (TARGET, SIMULATOR, CONTROLLER):  # an orbit is judged in the wind that blows
        values = {key: _plain(value) for key, value in sections[node].items()}
        if values and node in steering.nodes:
            refusal = steering.change(node, **values)
            (refusals if refusal else flown).append(refusal or node)
    if not (refusals or flown):
        return f"it says nothing of {', '.join(sorted(steering.nodes))}"
    if refusals and flown:
        refusals.append(f"what it says of {' and '.join(flown)} is flown")
    return "; ".join(refusals)


def _steered(node: str) -> tuple[str, ...]:
    """Parameters that make the mission."""
    if node == CONTROLLER:
        return ORBIT
    aside = PACE if node == SIMULATOR else ()
    known = specifications(SECTIONS[node])
    return tuple(each.name for each in known if not each.fixed and each.name not in aside)


def _plain(value: Any) -> Any:
    return list(value) if isinstance(value, tuple) else value


def fly_and_tell(client: viser.ClientHandle, steering: Steering, content: bytes) -> None:
    """Steer a flight as a scenario file says, and tell a page what comes of it; does not wait.

    Args:
        client: The page.
        steering: Of the flight.
        content: Of the file.
    """

    def told(refusal: str, _: str) -> None:
        client.add_notification(
            "The mission is refused, or some of it"
            if refusal
            else "The mission is flown from now on",
            refusal,
            color="red" if refusal else "green",
        )

    requests_of(steering).begin(lambda: fly_mission(steering, content), told)


class MissionFile(PanelPart):
    """Folded: buttons that save a file, take one and make a link."""

    name = "mission_file"
    order = 80.0

    @classmethod
    def fits(cls, flight: WatchedFlight, source: FlightSource) -> bool:
        """Whether there is something to steer.

        Args:
            flight: What is steered.
            source: Where it comes from.
        """
        return flight.steering is not None

    def add(self) -> None:
        """Add the buttons."""
        with self.gui.add_folder("Mission file", order=FOLDED, expand_by_default=False):
            save = self.gui.add_button(
                "Save mission", hint="Wind, target and orbit as they are now, for --scenario."
            )
            load: Any = self.gui.add_upload_button(
                "Fly a mission file", mime_type=".yaml,.yml", hint="One that was saved here."
            )
            link = self.gui.add_button(
                "Make a link", hint="Whoever has a page at this address can fly it by the link."
            )
            self._link = self.gui.add_html("", visible=False)
        save.on_click(self._save)
        load.on_upload(self._load)
        link.on_click(self._make_link)

    def _text(self) -> str:
        assert self.flight.steering is not None, "there is no such part without it"
        return mission_of(self.flight.steering, self.flight.name)

    def _save(self, event: Any) -> None:
        event.client.send_file_download(FILE, self._text().encode(), save_immediately=True)

    def _load(self, event: Any) -> None:
        assert self.flight.steering is not None, "there is no such part without it"
        fly_and_tell(event.client, self.flight.steering, event.target.value.content)

    def _make_link(self, _: Any) -> None:
        self._link.content = block(LINK.format(quote(self._text())))
        self._link.visible = True
