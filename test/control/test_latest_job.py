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

"""One thing after the other, of what waits only the latest."""

import threading
from types import SimpleNamespace

from uav_tracking_mpc.control import latest_job
from uav_tracking_mpc.control.latest_job import LatestJob


def test_of_what_waits_only_the_latest_counts():
    done, begun, go = [], threading.Event(), threading.Event()

    def work(number):
        begun.set()
        go.wait(30.0)
        done.append((threading.current_thread() is threading.main_thread(), number))

    job = LatestJob("test", work)
    job.wait()  # nothing was asked for
    job.ask(1)
    assert begun.wait(30.0)
    job.ask(2)
    job.ask(3)
    go.set()
    job.wait()
    assert done == [(False, 1), (False, 3)]
    job.ask(4)
    job.wait()
    assert done[-1] == (False, 4)


def test_work_that_raises_is_logged_and_the_next_is_done(caplog):
    done = []

    def work(number):
        if number == 1:
            raise KeyError("the first")
        done.append(number)

    job = LatestJob("margins", work)
    for number in (1, 2, 3):
        job.ask(number)
        job.wait()
    assert done == [2, 3]
    assert "margins" in caplog.text
    assert "the first" in caplog.text


def test_what_is_asked_for_as_the_rest_ends_is_done_too(monkeypatch):
    done, asking = [], iter([True])

    class Lock:
        """Before the thread of the job has it, something else is asked for."""

        def __init__(self):
            self._lock = threading.Lock()

        def __enter__(self):
            if threading.current_thread() is not threading.main_thread() and next(asking, False):
                job.ask(2)
            self._lock.acquire()

        def __exit__(self, *error):
            self._lock.release()

    monkeypatch.setattr(
        latest_job, "threading", SimpleNamespace(**vars(threading) | {"Lock": Lock})
    )
    job = LatestJob("test", done.append, rest=0.1)
    job.ask(1)
    job.wait()
    assert done == [2]
