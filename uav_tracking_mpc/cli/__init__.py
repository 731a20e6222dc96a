"""The ``uav_tracking`` command."""
