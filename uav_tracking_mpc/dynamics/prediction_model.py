"""What every prediction model says: its name, its state, and where a measurement puts it."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any, ClassVar

from numpy.typing import ArrayLike


class PredictionModel(ABC):
    """Base of the relative models (rates) and of the models of the vehicle (steps).

    Attributes:
        name: By which it is found.
        State: NamedTuple of the state's components.
    """

    name: ClassVar[str]
    State: ClassVar[Any]

    @abstractmethod
    def initial(self, vehicle: ArrayLike, target: ArrayLike, rates: ArrayLike) -> Any:
        """State of a measured motion, a ``State`` of floats.

        Args:
            vehicle: (x, y, z, psi, chi, v) in ``map``, shape (6,).
            target: Position in ``map``, shape (3,), in [m].
            rates: (psi', chi', v'), shape (3,), in [rad/s, rad/s, m/s^2].
        """
