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

"""Symbolic work, by one thread at a time.

CasADi gives the interpreter's lock away while it works, and two threads that build expressions at
the same time have been seen to end the process. Who builds expressions where another thread may do
so holds this lock; evaluating a function needs none.
"""

from __future__ import annotations

import functools
import threading
from collections.abc import Callable
from typing import ParamSpec, TypeVar

P = ParamSpec("P")
T = TypeVar("T")
LOCK = threading.RLock()


def one_at_a_time(function: Callable[P, T]) -> Callable[P, T]:
    """The function, which waits until no other thread does symbolic work.

    Args:
        function: That builds expressions.
    """

    @functools.wraps(function)
    def alone(*arguments: P.args, **named: P.kwargs) -> T:
        with LOCK:
            return function(*arguments, **named)

    return alone
