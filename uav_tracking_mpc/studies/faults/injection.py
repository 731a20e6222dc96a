"""How a fault is done and undone: one generator for each action, which yields while it lasts."""

from __future__ import annotations

import json
import random
import time
from collections.abc import Callable, Generator
from dataclasses import dataclass
from typing import Any

from uav_tracking_mpc.studies.faults.fault_kinds import (
    BUDGET,
    KILL,
    KINDS,
    RELAY,
    STARVE,
    STOP,
    STORM,
)
from uav_tracking_mpc.studies.faults.fault_relay import ORDERS
from uav_tracking_mpc.studies.faults.invariants import Violation
from uav_tracking_mpc.studies.faults.node_set import Crew
from uav_tracking_mpc.studies.faults.observer import Observer
from uav_tracking_mpc.studies.faults.parameter_storm import ParameterStorm
from uav_tracking_mpc.studies.faults.schedule import Fault

RESTART_LIMIT = 60.0  # s of wall time for a node that was killed to be heard again
GUST_PERIOD = 0.02  # s of wall time between requests of a storm
ANSWER_LIMIT = 5.0  # s of wall time for the parameters to be put back

Stroke = Generator[None, None, None]


@dataclass(frozen=True)
class Flight:
    """What faults strike.

    Attributes:
        crew: The processes.
        observer: Whose violations are added to.
        orders: Publisher of the relay's orders.
        storm: Client of the controller's parameters.
        speed: Simulated over wall time.
        reach: How far a target is teleported [m].
    """

    crew: Crew
    observer: Observer
    orders: Any
    storm: ParameterStorm
    speed: float
    reach: float


def stroke(fault: Fault, flight: Flight) -> Stroke:
    """The fault as a generator: it is over when the generator is."""
    return _STROKES[KINDS[fault.kind].action](fault, flight)


def _pause(seconds: float) -> Stroke:
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        yield


def _kill(fault: Fault, flight: Flight) -> Stroke:
    """Over when the new process is heard: loading takes wall time, which is no time of flight."""
    name = KINDS[fault.kind].victim
    flight.crew.kill(name)
    try:
        yield from _pause(fault.duration)
    finally:
        flight.crew.start(name)
    begin = time.monotonic()
    while flight.observer.heard.get(name, 0.0) < begin:
        if time.monotonic() - begin > RESTART_LIMIT:
            words = f"{name} was not heard within {RESTART_LIMIT:g} s of its new start"
            flight.observer.violations.append(Violation("restart", words))
            return
        yield


def _stop(fault: Fault, flight: Flight) -> Stroke:
    name = KINDS[fault.kind].victim
    flight.crew.freeze(name)
    try:
        yield from _pause(fault.duration)
    finally:
        flight.crew.thaw(name)


def _starve(fault: Fault, flight: Flight) -> Stroke:
    flight.crew.burn()
    try:
        yield from _pause(fault.duration)
    finally:
        flight.crew.extinguish()


def _relay(fault: Fault, flight: Flight) -> Stroke:
    seconds = fault.duration / flight.speed
    order = {
        "kind": fault.kind,
        "seed": fault.seed,
        "seconds": seconds,
        "speed": flight.speed,
        "reach": flight.reach,
    }
    flight.orders.publish(ORDERS.type(data=json.dumps(order)))
    yield from _pause(seconds)


def _parameters(ask: Callable[[], None], period: float, fault: Fault, flight: Flight) -> Stroke:
    end = time.monotonic() + fault.duration / flight.speed
    try:
        while time.monotonic() < end:
            ask()
            yield from _pause(period)
    finally:
        flight.storm.put_back()
    # Answers come in order: when this one is there, nothing of the storm is left.
    limit = time.monotonic() + ANSWER_LIMIT
    while flight.storm.answered < flight.storm.asked and time.monotonic() < limit:
        yield


def _storm(fault: Fault, flight: Flight) -> Stroke:
    rng = random.Random(fault.seed)
    return _parameters(lambda: flight.storm.gust(rng), GUST_PERIOD, fault, flight)


def _budget(fault: Fault, flight: Flight) -> Stroke:
    return _parameters(flight.storm.starve_solver, fault.duration, fault, flight)


_STROKES: dict[str, Callable[[Fault, Flight], Stroke]] = {
    KILL: _kill,
    STOP: _stop,
    STARVE: _starve,
    RELAY: _relay,
    STORM: _storm,
    BUDGET: _budget,
}
