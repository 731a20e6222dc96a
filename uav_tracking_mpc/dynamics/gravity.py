"""Gravity, once for all."""

GRAVITY = 9.80665  # m/s^2, standard gravity: 3rd General Conference on Weights and Measures, 1901
