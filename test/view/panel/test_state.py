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

"""What is flown and why, and what the nodes say."""

import pytest
from watched_flight_stand_in import StandInFlight, StandInSource, sight

from uav_tracking_mpc.control.fallback import FallbackMode
from uav_tracking_mpc.report.mode_colours import mode_colour
from uav_tracking_mpc.view.panel.state import SHOWN, Diagnostics, State
from uav_tracking_mpc.view.watched_flight import NodeStatus

LOST = {"mode": FallbackMode.LOITER, "reason": "target position is lost"}


@pytest.mark.parametrize(
    ("seen", "words"),
    [
        (
            [sight(**LOST)],
            ["loiter law", "target position is lost", f"rgb{mode_colour(FallbackMode.LOITER)}"],
        ),
        (
            [sight(), sight(11.0), sight(12.0, **LOST), sight(20.0), sight(25.0)],
            ["for 5 s", "before: loiter law, 8 s", "0:12.0, 8 s", "target position is lost"],
        ),
        (
            [sight(1.0), sight(2.0, mode=FallbackMode.LOITER), sight(2.2, **LOST), sight(5.0)],
            ["target position is lost"],
        ),
        ([sight(mode=None)], ["no command yet"]),
        ([sight(mode=FallbackMode.HOLD, reason="<img src=x>")], ["&lt;img src=x&gt;"]),
    ],
    ids=["fallback", "recovery", "a reason that comes after its mode", "no command", "no HTML"],
)
@pytest.mark.parametrize("begin", [0, -1], ids=["from the start", "opened later"])
def test_what_was_flown_is_told(panel, flight, seen, words, begin):
    shown = panel(State)
    for count in range(1, len(seen) + 1)[begin:]:
        flight.seen = seen[:count]
        text = shown.show()
    assert [word for word in words if word not in text] == []


def test_the_last_fallback_stands_on_top(panel, flight):
    flight.seen = [sight(1.0), sight(2.0, **LOST), sight(4.0)]
    flight.seen += [sight(10.0, mode=FallbackMode.HOLD, reason="no target position"), sight(11.0)]
    text = panel(State).show()
    assert text.index("0:10.0, 1 s") < text.index("0:02.0, 2 s")


def test_a_fallback_that_comes_again_and_again_is_told_once(panel, flight):
    modes = [FallbackMode.OPTIMAL, FallbackMode.FEASIBLE]
    flight.seen = [
        sight(0.2 * k, mode=modes[k % 2], reason="slow"[: 4 * (k % 2)]) for k in range(20)
    ]
    flight.seen.append(sight(4.0))
    text = panel(State).show()
    assert text.count("slow") == 1
    assert "0:00.2, 4 s, 10 times" in text


def test_events_do_not_grow_without_bound(panel, flight):
    modes = [FallbackMode.OPTIMAL, FallbackMode.LOITER]
    flight.seen = [sight(5.0 * k, mode=modes[k % 2]) for k in range(50)]
    text = panel(State).show()
    assert text.count("<div") <= 4 + SHOWN


def test_a_record_that_goes_back_tells_of_its_own_past(panel, flight):
    shown = panel(State)
    flight.seen = [sight(1.0), sight(2.0, **LOST), sight(4.0)]
    assert "loiter law" in shown.show()
    flight.seen = [sight(0.5), sight(1.0)]
    assert "loiter law" not in shown.show()


def test_what_is_past_is_folded_and_counted(panel, flight):
    shown = panel(State).shown()
    assert shown.widget("History: no fallback").expand_by_default is False
    flight.seen = [sight(11.0), sight(12.0, **LOST), sight(20.0)]
    shown.show()
    assert "History: 1 fallback" in shown.labels()


def test_the_folded_diagnostics_tell_the_worst_level(panel, flight):
    flight.seen = [sight(statuses=(NodeStatus("a", 0, ""), NodeStatus("b", 2, "")))]
    assert panel(Diagnostics).shown().widget("Diagnostics: error").expand_by_default is False


def test_each_node_has_its_level_and_words(panel, flight):
    nodes = [NodeStatus(f"node_{k}", k, f"words {k}") for k in range(4)]
    flight.seen = [sight(statuses=tuple(nodes))]
    lines = panel(Diagnostics).show().split("<div")[-4:]
    for node, level, line in zip(nodes, ("ok", "warning", "error", "silent"), lines, strict=True):
        assert node.node in line and level in line and node.words in line


def test_figures_fold_out_and_follow(panel, flight):
    shown = panel(Diagnostics)
    assert "12" in shown.show()
    assert shown.widget("nmpc_controller").expand_by_default is False
    flight.seen = [sight(statuses=(NodeStatus("nmpc_controller", 0, "", {"solves": "13"}),))]
    assert "13" in shown.show()


def test_it_is_absent_where_nobody_says_anything():
    flight = StandInFlight()
    source = StandInSource(flight)
    assert Diagnostics.fits(flight, source)
    flight.seen = [sight(statuses=())]
    assert not Diagnostics.fits(flight, source)
