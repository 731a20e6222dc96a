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

"""Parts that make requests: buttons, and widgets of parameters that follow what is flown."""

from __future__ import annotations

import html
import logging
import math
import threading
import time
import weakref
from abc import abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import viser

from uav_tracking_mpc.parameters.specification import specifications
from uav_tracking_mpc.view.panel import PanelPart
from uav_tracking_mpc.view.panel._html import ALARM, badge, block, faint
from uav_tracking_mpc.view.watched_flight import FlightSource, Sight, Steering, WatchedFlight

logger = logging.getLogger(__name__)

REFUSED, FAILED = "refused", "failed"
POLL_PERIOD = 1.0  # s of wall time between questions for a node's parameters


class Requests:
    """Asks one aircraft's steering, in threads of its own.

    Args:
        steering: What is asked.
    """

    def __init__(self, steering: Steering) -> None:
        self._steering, self._one_at_a_time = steering, threading.Lock()
        self._known: dict[str, dict[str, Any]] = {}
        self._polled: dict[str, float] = {}
        self._changes = 0

    def begin(self, request: Callable[[], str], done: Callable[[str, str], None]) -> None:
        """Make a request when those before it are answered.

        Args:
            request: Answers why it was refused, or nothing.
            done: Takes, in the thread of the request, words and what they are: of a refusal, of a
                failure, or none where it was done.
        """

        def ask() -> None:
            try:
                with self._one_at_a_time:
                    words, kind = request(), REFUSED
            except Exception as error:  # whatever it is, the page lives on
                logger.exception("a request of the page failed")
                words, kind = f"{type(error).__name__}: {error}", FAILED
            done(words, kind if words else "")

        threading.Thread(target=ask, daemon=True).start()

    def change(self, node: str, values: Mapping[str, Any]) -> str:
        """Change parameters; to be called by a request.

        Args:
            node: Whose.
            values: By name.

        Returns:
            Why it was refused; empty where it was done.
        """
        refusal = self._steering.change(node, **values)
        self._changes += 1  # what was asked for before may be of before
        if not refusal:
            self._known[node] = {**self._known.get(node, {}), **values}
        return refusal

    def parameters(self, node: str) -> Mapping[str, Any]:
        """Parameters as far as they are known, empty before the first answer; never waits.

        Args:
            node: Whose. About once a second it is asked again.
        """
        now = time.monotonic()
        if now >= self._polled.get(node, 0.0):
            self._polled[node] = float("inf")  # until it has answered
            threading.Thread(target=self._poll, args=(node,), daemon=True).start()
        return self._known.get(node, {})

    def _poll(self, node: str) -> None:
        changes = self._changes
        try:
            values = dict(self._steering.parameters(node))
            if values and changes == self._changes:
                self._known[node] = values
        except Exception as error:  # a node that is away: what was known stays
            logger.debug("parameters of %s: %s", node, error)
        finally:
            self._polled[node] = time.monotonic() + POLL_PERIOD


_of: weakref.WeakKeyDictionary[Steering, Requests] = weakref.WeakKeyDictionary()


def requests_of(steering: Steering) -> Requests:
    """The requests of an aircraft, the same for all parts of its panel.

    Args:
        steering: Of the aircraft.
    """
    return _of.setdefault(steering, Requests(steering))


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
        self.folder = self.gui.add_folder(self.title)
        with self.folder:
            self._line = self.gui.add_html("", order=LAST, visible=False)

    def say(self, words: str, of: str = "", under: Any = None) -> None:
        """Write the line of words.

        Args:
            words: As they are; nothing is shown where they are empty.
            of: What kind of words they are, to stand before them on a colour.
            under: Widget that they are about; below all of them by default.
        """
        self._line.order = LAST if under is None else under.order + 0.5
        self._line.content = block(
            badge(of, ALARM) + " " + html.escape(words) if of else faint(words)
        )
        self._line.visible = bool(words)

    def add_buttons(
        self,
        label: str,
        requests: Mapping[str, Callable[[], str]],
        hint: str,
        begun: Callable[[str], Any] = lambda chosen: None,
    ) -> viser.GuiButtonGroupHandle:
        """Add a row of buttons that make requests; they do nothing while one is under way.

        Args:
            label: Of the row.
            requests: Each answers why it was refused, or nothing; by the words on the button.
            hint: What they do, in words.
            begun: Called with a button's words when its request was done and not refused.
        """
        buttons = self.gui.add_button_group(label, tuple(requests), hint=hint or None)

        def clicked(event: viser.GuiEvent[viser.GuiButtonGroupHandle]) -> None:
            chosen, self.client = event.target.value, event.client
            if chosen in requests and not self.asking:
                self.ask(chosen, requests[chosen], lambda refusal: refusal or begun(chosen))

        buttons.on_click(clicked)
        return buttons

    def ask(
        self, what: str, request: Callable[[], str], then: Callable[[str], Any], under: Any = None
    ) -> None:
        """Make a request; buttons do nothing until it is answered.

        Args:
            what: Is asked for, in words.
            request: Answers why it was refused, or nothing.
            then: Takes the refusal, empty if there was none.
            under: Widget under which that stands; below all of them by default.
        """
        self.say(f"asking for {what} ...", under=under)
        self.asking = True

        def done(words: str, kind: str) -> None:
            self.asking = False
            self.say(words, of=kind, under=under)
            if kind == FAILED and self.client is not None:
                self.client.add_notification(f"{what}: the request failed", words, color="red")
            then(words)

        self.requests.begin(request, done)


STEPS = 150  # about so many from end to end of a slider
REST = 0.4  # s of wall time that a widget stands still before its value is sent
HANDS_OFF = 1.5  # s of wall time after which widgets follow what is flown again


@dataclass
class _Steered:
    """A widget: how it follows, what it asks for, its value when it was last looked at."""

    widget: Any  # mypy takes the value of viser's handles for one that cannot be set
    follow: Callable[[Mapping[str, Any]], None]
    values: Callable[[], dict[str, Any]]
    seen: Any
    wanted: bool = False


class ParameterPart(SteeringPart):
    """Widgets for parameters of ``node``.

    They appear when the parameters are known. A value is sent when its widget has come to rest. If
    it is refused, or somebody else changes it, the widget goes to what is flown.

    Attributes:
        section: Dataclass of the node's parameters.
    """

    period = 0.2
    section: ClassVar[type]

    def add(self) -> None:
        """Add the folder and wait for the parameters."""
        super().add()
        self.described = {known.name: known for known in specifications(self.section)}
        self._steered: list[_Steered] = []
        self._touched = -math.inf
        self.say(f"waiting for the parameters of {self.node}")

    @abstractmethod
    def build(self, known: Mapping[str, Any]) -> None:
        """Add the widgets.

        Args:
            known: Parameters of the node by name.
        """

    def steer(
        self,
        widget: Any,
        follow: Callable[[Mapping[str, Any]], None],
        values: Callable[[], dict[str, Any]],
    ) -> None:
        """Send what a widget is set to by hand, and let it follow what is flown.

        Args:
            widget: What is set.
            follow: Sets it to the parameters of the node.
            values: Parameters that it asks for, by name.
        """
        self._steered.append(_Steered(widget, follow, values, widget.value))

        def moved(event: viser.GuiEvent[Any]) -> None:
            if event.client is not None:  # else this program has set it
                self.client = event.client

        widget.on_update(moved)

    def add_slider(
        self, name: str, known: Mapping[str, Any], least: float, most: float, label: str = ""
    ) -> None:
        """Add a slider of one parameter.

        Args:
            name: Of the parameter.
            known: Parameters of the node by name.
            least: Sensible value in its unit [-].
            most: Sensible value in its unit [-].
            label: Beside it, where that is not to be the parameter's name.
        """
        described, value = self.described[name], float(known[name])
        step = round_step((most - least) / STEPS)
        least = step * math.floor(least / step + 1e-9)
        most = step * math.ceil(most / step - 1e-9)
        if described.lower is not None:
            least = max(least, described.lower)
        if described.upper is not None:
            most = min(most, described.upper)
        unit = f" [{described.unit}]" if described.unit else ""
        slider = self.gui.add_slider(
            (label or name.replace("_", " ")) + unit,
            min=min(round(least, 9), value),
            max=max(round(most, 9), value),
            step=step,
            initial_value=value,
            hint=f"{described.description} Allowed: {described.allowed}.",
        )
        self.steer(
            slider,
            lambda now: set_slider(slider, float(now[name])),
            lambda: {name: float(slider.value)},
        )

    def add_choice(
        self,
        name: str,
        known: Mapping[str, Any],
        options: Sequence[Any],
        hint: str | None = None,
        form: str = "{}",
    ) -> None:
        """Add a list of values of one parameter; one that somebody else has set joins it.

        Args:
            name: Of the parameter.
            known: Parameters of the node by name.
            options: Values to choose from.
            hint: What it does, in words.
            form: How a value is written.
        """
        values = {form.format(option): option for option in options}

        def shown(now: Mapping[str, Any]) -> str:
            words = form.format(now[name])
            values.setdefault(words, now[name])
            return words

        first = shown(known)
        choice: Any = self.gui.add_dropdown(name, list(values), initial_value=first, hint=hint)

        def follow(now: Mapping[str, Any]) -> None:
            words = shown(now)
            if words not in choice.options:
                choice.options = tuple(values)
            choice.value = words

        self.steer(choice, follow, lambda: {name: values[choice.value]})

    def show(self, sight: Sight) -> None:
        """Send what has come to rest, or follow what is flown.

        Args:
            sight: Of this aircraft.
        """
        known = self.requests.parameters(self.node)
        if not known:
            return
        if not self._steered:
            self.say("")
            with self.folder:
                self.build(known)
        self._look_at_hands()
        still = time.monotonic() - self._touched
        wanted = [steered for steered in self._steered if steered.wanted]
        if wanted and still > REST and not self.asking:
            self._send(wanted)
        elif not wanted and still > HANDS_OFF and not self.asking:
            for steered in self._steered:
                steered.follow(known)
                steered.seen = steered.widget.value

    def _look_at_hands(self) -> None:
        """Find widgets that were set by hand.

        By their values and not in their callbacks: those come later, in other threads.
        """
        for steered in self._steered:
            value = steered.widget.value
            options = getattr(steered.widget, "options", (value,))
            endless = isinstance(value, float) and not math.isfinite(value)
            if endless or value not in options:
                steered.widget.value = steered.seen
                words = f"{steered.widget.label} cannot be {value}"
                self.say(words, of=REFUSED, under=steered.widget)
            elif value != steered.seen:
                steered.seen, steered.wanted = value, True
                self._touched = time.monotonic()

    def _send(self, wanted: list[_Steered]) -> None:
        values: dict[str, Any] = {}
        for steered in wanted:
            values |= steered.values()
            steered.wanted = False

        def answered(refusal: str) -> None:
            if refusal and not any(steered.wanted for steered in self._steered):
                self._touched = -math.inf  # what is flown is shown at once

        words = ", ".join(f"{name} {_short(value)}" for name, value in values.items())
        request, last = lambda: self.requests.change(self.node, values), wanted[-1].widget
        self.ask(words, request, answered, under=last)


def set_slider(slider: Any, value: float) -> None:
    """Set a slider, also beyond what it spanned.

    Args:
        slider: What is set.
        value: In the unit of the parameter [-].
    """
    slider.min, slider.max = min(slider.min, value), max(slider.max, value)
    slider.value = value


def round_step(step: float) -> float:
    """The least of 1, 2, 5, 10 and so on that is not smaller.

    Args:
        step: Positive [-].
    """
    decade = 10.0 ** math.floor(math.log10(step))
    return next(round(f * decade, 12) for f in (1.0, 2.0, 5.0, 10.0) if f * decade >= step * 0.999)


def _short(value: Any) -> str:
    if isinstance(value, (tuple, list)):
        return "[" + ", ".join(_short(element) for element in value) + "]"
    return f"{value:.4g}" if isinstance(value, float) else str(value)
