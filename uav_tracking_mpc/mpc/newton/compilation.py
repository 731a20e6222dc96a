"""How every function of the method is compiled."""

from numba import njit

# Sums may be reordered and fused; NaN and infinity keep their meaning: the line search relies on it.
compiled = njit(
    error_model="numpy", fastmath={"contract", "reassoc", "nsz", "arcp"}, no_cpython_wrapper=True
)
