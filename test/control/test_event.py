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

from uav_tracking_mpc.control.event import CAPACITY, EventLog, Level


def test_events_are_taken_once_oldest_first():
    log = EventLog()
    log.add(Level.INFO, "one")
    log.add(Level.WARNING, "two")
    assert log.take() == [(Level.INFO, "one"), (Level.WARNING, "two")]
    assert log.take() == []


def test_what_nobody_takes_does_not_grow():
    log = EventLog()
    for number in range(CAPACITY + 5):
        log.add(Level.INFO, str(number))
    events = log.take()
    assert (len(events), events[0].words) == (CAPACITY, "5")
