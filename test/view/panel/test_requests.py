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

import threading
import time

from watched_flight_stand_in import StandInSteering

from uav_tracking_mpc.view.panel._requests import Requests, requests_of
from uav_tracking_mpc.view.steering import CONTROLLER

WAIT = 60.0  # s


def asked(requests, request):
    """Event of the answer to a request that has begun."""
    answered = threading.Event()
    requests.begin(request, lambda refusal: answered.set(), lambda words: None)
    return answered


def test_one_at_a_time():
    steering = StandInSteering()
    requests = Requests(steering)
    steering.go_on.clear()
    events = [asked(requests, lambda: steering.pause(True)), asked(requests, steering.reset)]
    while not steering.asked:
        time.sleep(0.01)
    time.sleep(0.1)  # in which a second one would begin
    assert len(steering.asked) == 1
    steering.go_on.set()
    assert all(event.wait(WAIT) for event in events)
    assert len(steering.asked) == 2


def test_all_parts_share_those_of_an_aircraft():
    one, another = StandInSteering(), StandInSteering()
    assert requests_of(one) is requests_of(one)
    assert requests_of(one) is not requests_of(another)


def test_parameters_are_not_waited_for():
    steering = StandInSteering()
    requests = Requests(steering)
    end = time.monotonic() + WAIT
    while not requests.parameters(CONTROLLER):
        assert time.monotonic() < end
        time.sleep(0.01)
    assert requests.parameters(CONTROLLER)["range"] == 300.0


def test_an_answer_of_before_a_change_is_not_believed():
    """A node that was asked before a change and answers after it tells what was."""
    steering = StandInSteering()
    requests, before, answers = Requests(steering), dict(steering.values[CONTROLLER]), []
    asked_, go_on = threading.Event(), threading.Event()

    def slowly(node):
        asked_.set()
        go_on.wait()
        answers.append(node)
        return before

    steering.parameters = slowly
    requests.parameters(CONTROLLER)
    assert asked_.wait(WAIT)
    assert requests.change(CONTROLLER, {"range": 350.0}) == ""
    go_on.set()
    end = time.monotonic() + WAIT
    while not answers:
        assert time.monotonic() < end
        time.sleep(0.01)
    steering.parameters = lambda node: dict(steering.values[node])
    while requests._polled[CONTROLLER] == float("inf"):
        time.sleep(0.01)
    assert requests._known[CONTROLLER]["range"] == 350.0
