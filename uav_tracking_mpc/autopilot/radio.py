"""The wire of the simulated autopilot, on which faults can act."""

from __future__ import annotations

from uav_tracking_mpc.links.mavlink.connection import Connection


class Radio(Connection):
    """A connection."""
