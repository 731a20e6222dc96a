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

"""Guidance laws beside a flight: they are asked for, and their errors are told."""

import numpy as np
from watched_flight_stand_in import StandInFlight, StandInSource, sight

from uav_tracking_mpc.view.panel.compare import Compare
from uav_tracking_mpc.view.watched_flight import RivalSight

BOX = "classical laws"


def beside(time, ours, theirs):
    rival = RivalSight("l1", np.zeros(3), 0.0, 0.0, 0.0, theirs)
    return sight(time, errors={"range_error": ours}, rivals=(rival,))


def test_they_are_asked_for_by_a_box(panel, flight):
    shown = panel(Compare)
    for on in (True, False):
        shown.by_hand(BOX, on)
        shown.until(lambda: "asking" not in shown.text)
    assert flight.steering.asked == [("compare", True), ("compare", False)]


def test_errors_of_now_and_of_the_last_minute(panel, flight):
    flight.seen = [sight(0.0)]
    shown = panel(Compare).shown(beside(10.0, 3.0, 40.0), beside(11.0, 4.0, 30.0))
    rows = shown.text.split("<tr")
    assert "+4.0" in rows[-2] and "3.5" in rows[-2]
    assert "l1" in rows[-1] and "+30.0" in rows[-1] and "35.4" in rows[-1]
    assert "l1" not in shown.show(sight(12.0))


def test_it_is_absent_where_nothing_can_be_compared(flight):
    flight.steering.comparable = False
    assert not Compare.fits(flight, StandInSource(flight))
    assert not Compare.fits(StandInFlight(), StandInSource(flight))
