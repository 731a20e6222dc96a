"""How every function of the method is compiled."""

from numba import njit

# Sums may be reordered and fused; NaN and infinity keep their meaning, for the line search.
# _nrt=False: no reference counting, so code that would allocate does not compile.
OPTIONS = {
    "error_model": "numpy",
    "fastmath": {"contract", "reassoc", "nsz", "arcp"},
    "_nrt": False,
}
compiled = njit(**OPTIONS, no_cpython_wrapper=True, no_cfunc_wrapper=True)
entry = njit(**OPTIONS, no_cfunc_wrapper=True, cache=True, nogil=True)
