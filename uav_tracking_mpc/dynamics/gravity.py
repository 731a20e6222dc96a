"""Standard gravity."""

# Resolution 2 of the 3rd General Conference on Weights and Measures (1901), in [m/s^2].
GRAVITY = 9.80665
