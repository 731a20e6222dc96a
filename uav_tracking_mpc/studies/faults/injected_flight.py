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

"""The flight that faults act on."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from uav_tracking_mpc.launch.supervisor import Supervisor
from uav_tracking_mpc.studies.faults.observer import Observer
from uav_tracking_mpc.studies.faults.parameter_client import ParameterClient


@dataclass(frozen=True)
class Flight:
    """What faults act on.

    Attributes:
        supervisor: Of the node processes.
        observer: Node that hears every message.
        order: Sends an order to the relay, as text.
        parameters: Client of the controller's parameters.
        speed: Simulated over wall time [-].
        reach: How far a target is teleported [m].
    """

    supervisor: Supervisor
    observer: Observer
    order: Callable[[str], None]
    parameters: ParameterClient
    speed: float
    reach: float
