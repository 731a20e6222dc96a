"""The two figures of a flight as files."""

from __future__ import annotations

from pathlib import Path

from uav_tracking_mpc.report.atomic_write import write_atomically
from uav_tracking_mpc.report.figure_style import png
from uav_tracking_mpc.report.states import states_figure
from uav_tracking_mpc.report.trajectory import trajectory_figure
from uav_tracking_mpc.simulation.flight_log import FlightLog


def save_trajectory(log: FlightLog, path: Path) -> bytes:
    """Draw the flight in space, as Figure 2 of the paper.

    Args:
        log: Record of the flight.
        path: PNG file to write; its folder exists.

    Returns:
        The file's content.
    """
    content = png(trajectory_figure(log))
    write_atomically(Path(path), content)
    return content


def save_states(log: FlightLog, path: Path) -> bytes:
    """Draw states, inputs and cost over time, as Figure 3 of the paper.

    Args:
        log: Record of the flight.
        path: PNG file to write; its folder exists.

    Returns:
        The file's content.
    """
    content = png(states_figure(log))
    write_atomically(Path(path), content)
    return content
