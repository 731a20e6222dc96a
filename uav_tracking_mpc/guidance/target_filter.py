"""Where the target is: a constant-velocity Kalman filter on measured positions."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray


class TargetFilter:
    r"""Position and velocity of a target from positions that come noisy and at any rate.

    Each axis follows p' = v, v' = w with w white noise of spectral density q, measured with noise
    of variance r. The axes share their covariance, which does not depend on the data.

    .. math:: F = \begin{bmatrix}1&dt\\0&1\end{bmatrix},\quad
              Q = q\begin{bmatrix}dt^3/3&dt^2/2\\dt^2/2&dt\end{bmatrix}

    Args:
        noise: Standard deviation of a measured position in [m].
        agility: Acceleration that the target may show in [m/s^2]; q is its square times 1 s.
        speed: Standard deviation of the velocity before anything is known of it in [m/s].
    """

    def __init__(self, noise: float, agility: float, speed: float = 10.0) -> None:
        self._r = noise**2
        self._q = agility**2
        self._initial_covariance = np.diag([noise**2, speed**2])
        self.reset()

    def reset(self) -> None:
        """Forget the target."""
        self._time: float | None = None
        self._state = np.zeros((2, 3))  # rows: position, velocity
        self._covariance = self._initial_covariance.copy()

    @property
    def time(self) -> float | None:
        """Time of the latest measurement in [s], None before the first."""
        return self._time

    def update(self, time: float, position: ArrayLike) -> bool:
        """Take in one measured position.

        Args:
            time: When it was measured in [s].
            position: In ``map``, shape (3,), in [m].

        Returns:
            False if it is not newer than the latest and was left out.

        Raises:
            ValueError: The position is not three finite numbers; the filter is unchanged.
        """
        measured = np.asarray(position, dtype=float)
        if measured.shape != (3,) or not np.all(np.isfinite(measured)):
            raise ValueError(f"target position is {position!r}, must be three finite numbers")
        if self._time is None:
            self._time = time
            self._state[0] = measured
            return True
        if time <= self._time:
            return False
        transition, diffusion = self._motion(time - self._time)
        state = transition @ self._state
        covariance = transition @ self._covariance @ transition.T + diffusion
        gain = covariance[:, 0] / (covariance[0, 0] + self._r)
        self._state = state + np.outer(gain, measured - state[0])
        self._covariance = covariance - np.outer(gain, covariance[0])
        self._time = time
        return True

    def predict(self, time: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Position [m] and velocity [m/s], each of shape (3,), at a time.

        Raises:
            ValueError: Nothing has been measured yet.
        """
        if self._time is None:
            raise ValueError("no target position has been received yet")
        transition, _ = self._motion(time - self._time)
        position, velocity = transition @ self._state
        return position, velocity

    def _motion(self, dt: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        transition = np.array([[1.0, dt], [0.0, 1.0]])
        diffusion = self._q * np.array([[dt**3 / 3.0, dt**2 / 2.0], [dt**2 / 2.0, dt]])
        return transition, diffusion
