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

"""What somebody may have meant who mistyped a name."""

from __future__ import annotations

import difflib
from collections.abc import Iterable


def did_you_mean(name: object, known: Iterable[object]) -> str:
    """The nearest name in words, to stand right behind the wrong one; "" if none is near.

    Args:
        name: As it was typed.
        known: Names that there are.
    """
    spelt = {str(candidate).lower(): str(candidate) for candidate in known}
    if str(name) in spelt.values():
        return ""
    nearest = difflib.get_close_matches(str(name).lower(), spelt, n=1)
    return f" (did you mean {spelt[nearest[0]]!r}?)" if nearest else ""
