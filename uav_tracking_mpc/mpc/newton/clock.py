"""Wall time inside compiled code."""

from numba import types

from .numba_options import compiled

MONOTONIC = 1  # CLOCK_MONOTONIC of POSIX on Linux

_clock_gettime = types.ExternalFunction("clock_gettime", types.int32(types.int32, types.uintp))


@compiled
def now(instant):
    """Seconds on the monotonic clock.

    Args:
        instant: Two int64 that the C library fills with seconds and nanoseconds.
    """
    _clock_gettime(MONOTONIC, instant.ctypes.data)
    return instant[0] + 1e-9 * instant[1]
