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

from watched_flight_stand_in import StandInFlight, StandInSource, sight

from uav_tracking_mpc.view.panel.diagnostics import Diagnostics
from uav_tracking_mpc.view.sight import NodeStatus


def test_each_node_has_its_level_and_words(panel, flight):
    names = "ok", "warning", "error", "silent"
    flight.seen = [
        sight(statuses=tuple(NodeStatus(f"node_{k}", k, f"words {k}") for k in range(4)))
    ]
    text = panel(Diagnostics).show()
    for k, level in enumerate(names):
        line = next(line for line in text.split("<div") if f"node_{k}" in line)
        assert level in line
        assert f"words {k}" in line


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
