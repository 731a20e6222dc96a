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

"""Two threads never do symbolic work together; one may nest it."""

import threading
import time

from uav_tracking_mpc.dynamics.symbolic_work import one_at_a_time


def test_one_thread_waits_for_the_other():
    inside, most = [], []

    @one_at_a_time
    def work(name):
        inside.append(name)
        most.append(len(inside))
        time.sleep(0.01)
        inside.remove(name)
        return name

    threads = [threading.Thread(target=work, args=(name,)) for name in range(6)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert most == [1] * 6
    assert work("again") == "again"


def test_work_may_call_other_work():
    inner = one_at_a_time(lambda value: value + 1)
    assert one_at_a_time(lambda value: 2 * inner(value))(3) == 8
