"""Every kind of fault: whom it strikes, by what means, and for how long."""

from __future__ import annotations

from dataclasses import dataclass

NODES = ("uav_simulator", "target_publisher", "nmpc_controller")
ODOMETRY, AIR, TARGET, COMMAND, CLOCK = (
    "uav/odometry",
    "uav/air_velocity",
    "target/position",
    "uav/command",
    "/clock",
)
STREAMS = (ODOMETRY, AIR, TARGET, COMMAND, CLOCK)

KILL, STOP, STARVE = "kill", "stop", "starve"  # what happens to processes
RELAY = "relay"  # what happens to messages on their way
STORM, BUDGET = "storm", "budget"  # what happens to parameters


@dataclass(frozen=True)
class FaultKind:
    """One kind of fault.

    Attributes:
        name: Unique.
        family: Faults that belong together in a figure.
        action: By what means it is done.
        shortest: Least duration [s]; of simulated time for messages and parameters, of wall time
            for processes.
        longest: Greatest duration [s].
        victim: Node that is killed or stopped; empty where none is.
        streams: Topics that it strikes.
    """

    name: str
    family: str
    action: str
    shortest: float
    longest: float
    victim: str = ""
    streams: tuple[str, ...] = ()


# Corruptions of one message's fields, by topic; `corruption` says what each of them does.
CORRUPTIONS = ("nan", "inf", "huge", "frame", "old_stamp", "future_stamp")
ORDERINGS = ("duplicated", "reordered")
_OF_TOPIC = {
    "odometry": (ODOMETRY, ("quaternion", "negative_speed", "absurd")),
    "target": (TARGET, ("absurd",)),
    "command": (COMMAND, ("absurd", "empty")),
    "air_velocity": (AIR, ("negative_speed",)),
}


def _kinds() -> tuple[FaultKind, ...]:
    kinds = []
    for node in NODES:
        kinds.append(FaultKind(f"kill_{node}", "process", KILL, 0.0, 1.0, node))
        kinds.append(FaultKind(f"stop_{node}", "process", STOP, 0.5, 3.0, node))
    kinds.append(FaultKind("cpu_starvation", "process", STARVE, 0.5, 2.0))
    kinds.append(FaultKind("loss", "network", RELAY, 2.0, 6.0, streams=STREAMS))
    kinds.append(FaultKind("jitter", "network", RELAY, 2.0, 6.0, streams=STREAMS))
    kinds.append(FaultKind("gap_state", "network", RELAY, 1.0, 1.0, streams=(ODOMETRY, AIR)))
    kinds.append(FaultKind("gap_target", "network", RELAY, 1.0, 1.0, streams=(TARGET,)))
    kinds.append(FaultKind("gap_command", "network", RELAY, 1.0, 1.0, streams=(COMMAND,)))
    for name, (topic, more) in _OF_TOPIC.items():
        for fault in (*CORRUPTIONS, *ORDERINGS, *more):
            kinds.append(FaultKind(f"{name}_{fault}", name, RELAY, 1.0, 3.0, streams=(topic,)))
    kinds.append(FaultKind("target_teleport", "target", RELAY, 1.0, 4.0, streams=(TARGET,)))
    kinds.append(FaultKind("target_lost", "target", RELAY, 6.0, 9.0, streams=(TARGET,)))
    for fault in ("clock_forward", "clock_backward", "clock_pause"):
        kinds.append(FaultKind(fault, "clock", RELAY, 1.0, 4.0, streams=(CLOCK,)))
    kinds.append(FaultKind("parameter_storm", "parameters", STORM, 1.0, 3.0))
    kinds.append(FaultKind("solver_budget", "parameters", BUDGET, 1.0, 3.0))
    return tuple(kinds)


KINDS = {kind.name: kind for kind in _kinds()}
FAMILIES = tuple(dict.fromkeys(kind.family for kind in KINDS.values()))
