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

"""Every fault that a campaign may inject, by its label."""

from __future__ import annotations

from collections.abc import Iterable

from uav_tracking_mpc.parameters.registry import FAULT, ExtensionError
from uav_tracking_mpc.studies.faults.kinds import Fault


def variants(reference: str) -> dict[str, Fault]:
    """Variants of one class of faults.

    Args:
        reference: Name of the class in its room, or ``path.py:Class``.

    Returns:
        A new object of each, by its label.

    Raises:
        ExtensionError: There is no such class.
    """
    found = {}
    for fault in FAULT.find(reference).variants():
        fault.reference = reference
        found[fault.label] = fault
    return found


def catalogue(references: Iterable[str] = ()) -> dict[str, Fault]:
    """Variants of all faults that are installed, and of others.

    Args:
        references: Others, as ``path.py:Class``.

    Returns:
        Faults by label, those of a family side by side.

    Raises:
        ExtensionError: There is no such class, or it has the label of another one.
    """
    faults: dict[str, Fault] = {}
    for reference in dict.fromkeys((*FAULT.names, *references)):
        for label, fault in variants(reference).items():
            if label in faults:
                raise ExtensionError(
                    f"fault {reference!r} has the label {label!r} of fault "
                    f"{faults[label].reference!r}"
                )
            faults[label] = fault
    return dict(sorted(faults.items(), key=lambda item: (item[1].family, item[0])))
