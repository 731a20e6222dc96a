"""Standard gravity."""

GRAVITY = 9.80665  # m/s^2; 3rd General Conference on Weights and Measures, 1901, Resolution 2
