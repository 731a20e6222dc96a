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

"""Which laws can be compared, by name."""

from __future__ import annotations

from uav_tracking_mpc.parameters.registry import GUIDANCE_LAW
from uav_tracking_mpc.settings.tracking import PREDICTIVE


def law_names() -> list[str]:
    """The predictive controller and every law that is installed."""
    return [PREDICTIVE, *GUIDANCE_LAW.names]


def law_label(law: str) -> str:
    """What tables and figures call a law.

    Args:
        law: A name, or ``path.py:Class``.

    Raises:
        ExtensionError: There is no such law.
    """
    return str(GUIDANCE_LAW.find(law).name) if ":" in law else law
