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
