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

"""An element or a part that fails is switched off with its words; page, flight and report go on."""

import numpy as np
import pytest
import viser
from example_flights import orbiting
from watched_flight_stand_in import StandInFlight, StandInSource, StandInSteering, sight

from uav_tracking_mpc import load_configuration
from uav_tracking_mpc.report.mission_report import write_report
from uav_tracking_mpc.report.mode_colours import MODE_COLOURS
from uav_tracking_mpc.view.page import Page, legend
from uav_tracking_mpc.view.panel import PANEL_PART, PanelPart
from uav_tracking_mpc.view.recorded_scene import recorded_scene
from uav_tracking_mpc.view.scene import LIMIT, SCENE_ELEMENT, WIND, SceneElement

BEGIN, WHILE = "it begins", "it is shown"


class Failing:
    """Fails when it begins, or with the second sight."""

    name, when = "failing", BEGIN

    def add(self):
        self.shown = 0
        self.mark = self.added()
        if self.when == BEGIN:
            raise ZeroDivisionError("of a user's own")

    def show(self, sight):
        self.shown += 1
        if self.shown > 1:
            raise ZeroDivisionError("of a user's own")


class FailingElement(Failing, SceneElement):
    def added(self):
        return self.scene.add_icosphere(f"{self.root}/failing", 1.0)


class FailingPart(Failing, PanelPart):
    period = 0.0

    def added(self):
        return self.gui.add_html("of what has failed")


class FailingFit(PanelPart):
    name = "failing"

    @classmethod
    def fits(cls, flight, source):
        raise ZeroDivisionError("of a user's own")

    def add(self): ...

    def show(self, sight): ...


@pytest.fixture
def installed(monkeypatch):
    """Puts a class among those of its kind."""

    def install(registry, kind, **attributes):
        for name, value in attributes.items():
            monkeypatch.setattr(kind, name, value)
        known, every = {"failing": kind, **registry.all()}, type(registry).all
        monkeypatch.setattr(
            type(registry), "all", lambda self: known if self is registry else every(self)
        )

    return install


@pytest.fixture
def page():
    flight = StandInFlight(steering=StandInSteering())
    page = Page(StandInSource(flight), None, 0)
    page.flight = flight
    yield page
    page.close()


def frames(page, count=4):
    """Serve so many frames, the aircraft moving."""
    left = iter(range(count))

    def ended():
        number = next(left, None)
        if number is not None:
            place = np.array([275.0, float(number), 121.0])
            page.flight.seen.append(sight(10.0 + number, position=place))
        return number is None

    page.serve(ended)


def words(page):
    """All words of the panel that are visible."""
    found, rest = [], [page._server.gui._container_handle_from_uuid["root"]]
    while rest:
        handle = rest.pop()
        if getattr(handle, "visible", True) and hasattr(handle, "content"):
            found.append(handle.content)
        rest += getattr(handle, "_children", {}).values()
        rest += getattr(handle, "_tab_handles", ())
    return "\n".join(found)


@pytest.mark.parametrize("when", [BEGIN, WHILE])
def test_a_failing_element_is_switched_off_and_the_others_are_drawn(page, installed, when):
    installed(SCENE_ELEMENT, FailingElement, when=when)
    frames(page)
    scene = page._server.scene
    assert not scene.get_handle_by_name("/world/aircraft/failing").visible
    np.testing.assert_allclose(
        scene.get_handle_by_name("/world/aircraft/aircraft").position, [275.0, 3.0, 121.0]
    )
    assert "failing: ZeroDivisionError: of a user&#x27;s own" in words(page)
    assert "Airspeed" in words(page)


class Standing(SceneElement):
    """Sets the same place in each frame."""

    def add(self):
        self.frame = self.scene.add_frame(f"{self.root}/standing")

    def show(self, sight):
        self.frame.position = (1.0, 2.0, 3.0)


def test_what_stands_is_not_told_again_and_what_a_page_has_moved_is_put_back(
    page, installed, monkeypatch
):
    installed(SCENE_ELEMENT, Standing)
    told = []
    place = viser.SceneNodeHandle.position
    setter = property(place.fget, lambda self, to: (told.append(self.name), place.fset(self, to)))
    monkeypatch.setattr(viser.SceneNodeHandle, "position", setter)
    frames(page)
    assert told.count("/world/aircraft/standing") == 2  # made and placed
    assert told.count("/world/aircraft/aircraft") == 5
    frame = page._server.scene.get_handle_by_name("/world/aircraft/standing")
    frame._impl.position[:] = 9.0  # as viser does when a page moves it
    frames(page)
    np.testing.assert_allclose(frame.position, [1.0, 2.0, 3.0])


@pytest.mark.parametrize(
    ("kind", "attributes"),
    [(FailingPart, {"when": BEGIN}), (FailingPart, {"when": WHILE}), (FailingFit, {})],
)
def test_a_failing_part_is_switched_off_and_the_others_are_read(page, installed, kind, attributes):
    installed(PANEL_PART, kind, **attributes)
    frames(page)
    assert "failing: ZeroDivisionError: of a user&#x27;s own" in words(page)
    assert "of what has failed" not in words(page)
    assert "Airspeed" in words(page)


def test_a_page_that_cannot_draw_lives_on_and_says_so_once(page, monkeypatch, caplog):
    def failing(_):
        raise ZeroDivisionError("of the visitors")

    monkeypatch.setattr(page._visitors, "show", failing)
    frames(page)
    (record,) = caplog.records
    assert "a frame was not drawn" in record.getMessage()


def test_a_report_has_its_scene_without_the_element_that_fails(tmp_path, installed):
    installed(SCENE_ELEMENT, FailingElement, when=WHILE)
    tracking = load_configuration("paper").controller
    log = orbiting(9, tracking.orbit, tracking=tracking)
    write_report(log, tmp_path, recorded_scene)
    assert "data-scene" in (tmp_path / "report.html").read_text()


def test_a_report_is_written_whatever_happens_to_its_scene(tmp_path):
    def failing(log):
        raise ZeroDivisionError("of the scene")

    numbers = write_report(orbiting(9), tmp_path, failing)
    page = (tmp_path / "report.html").read_text()
    assert "could not be made: ZeroDivisionError: of the scene" in page
    assert "pip install" not in page
    assert numbers["steady_state"]


def test_every_colour_has_its_words():
    words = legend((1, 2, 3))
    for colour in (*MODE_COLOURS.values(), WIND, LIMIT, (1, 2, 3)):
        assert f"rgb{colour}" in words
    for mode in MODE_COLOURS:
        assert mode.value in words
    assert "Drag the target" in words
