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

"""What may be claimed of a terminal set, apart from what decides it (``status``)."""

from __future__ import annotations

from dataclasses import dataclass

CERTIFIED, SAMPLED, NEITHER = "certified", "sampled", "neither"


@dataclass(frozen=True)
class CertificateStatus:
    """What a controller may claim.

    Attributes:
        status: ``certified`` (a certificate covers what is flown, and the checker confirms it),
            ``sampled`` (none does, but no sample of X_f breaks the condition) or ``neither``.
        reason: In words.
    """

    status: str
    reason: str
