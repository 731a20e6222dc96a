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

import pytest
from watched_flight_stand_in import StandInFlight, StandInSource

from uav_tracking_mpc.view.panel.engagement import Engagement


@pytest.mark.parametrize(("label", "on"), [("Engage", True), ("Disengage", False)])
def test_buttons(label, on, panel, flight):
    shown = panel(Engagement)
    shown.by_hand("commands", label)
    shown.until(lambda: flight.steering.asked)
    assert flight.steering.asked == [("engage", on)]


def test_a_button_that_there_is_not_does_nothing(panel, flight, capfd):
    shown = panel(Engagement)
    shown.by_hand("commands", "no such button")
    shown.by_hand("commands", "Engage")
    shown.until(lambda: flight.steering.asked)
    assert flight.steering.asked == [("engage", True)]
    assert capfd.readouterr().err == ""


def test_it_is_absent_from_a_record():
    flight = StandInFlight()
    assert not Engagement.fits(flight, StandInSource(flight))
