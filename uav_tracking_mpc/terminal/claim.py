"""What may be claimed of a terminal set, apart from what decides it (``status``)."""

from __future__ import annotations

from dataclasses import dataclass

CERTIFIED, SAMPLED, NEITHER = "certified", "sampled", "neither"


@dataclass(frozen=True)
class CertificateStatus:
    """What a controller may claim.

    Attributes:
        status: ``certified`` (a certificate covers what is flown, and the checker confirms it),
            ``sampled`` (none does, but no sample of X_f breaks the condition) or ``neither``.
        reason: In words.
    """

    status: str
    reason: str
