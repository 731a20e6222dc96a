"""Which laws can be compared, by name."""

from __future__ import annotations

from uav_tracking_mpc.parameters.registry import GUIDANCE_LAW
from uav_tracking_mpc.settings.tracking import PREDICTIVE


def law_names() -> list[str]:
    """The predictive controller and every law that is installed."""
    return [PREDICTIVE, *GUIDANCE_LAW.names]


def law_label(law: str) -> str:
    """What tables and figures call a law.

    Args:
        law: A name, or ``path.py:Class``.

    Raises:
        ExtensionError: There is no such law.
    """
    return str(GUIDANCE_LAW.find(law).name) if ":" in law else law
