"""What is known of the air and of the sensors' biases, as values for /diagnostics."""

from __future__ import annotations

import math

from uav_tracking_mpc.estimation.wind_filter import WindFilter

AXES = ("east", "north", "up")


def air_values(air: WindFilter) -> dict[str, object]:
    """Keys, with units, and values.

    Args:
        air: Filter of wind and biases.
    """
    vectors = {
        "mean wind": air.mean_wind,
        "gust": air.gust,
        "bias of ground velocity": air.ground_velocity_bias,
    }
    return {
        **{
            f"{name} {axis} [m/s]": value
            for name, vector in vectors.items()
            for axis, value in zip(AXES, vector.tolist(), strict=True)
        },
        "airspeed reads too much by [%]": 100.0 * air.airspeed_share,
        "bias of heading [deg]": math.degrees(air.heading_bias),
    }
