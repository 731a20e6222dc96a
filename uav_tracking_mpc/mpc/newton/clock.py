# Copyright 2026 uav_tracking_mpc maintainers
#
# Licensed under the Apache License, Version 2.0 (the "License");
# you may not use this file except in compliance with the License.
# You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software
# distributed under the License is distributed on an "AS IS" BASIS,
# WITHOUT WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied.
# See the License for the specific language governing permissions and
# limitations under the License.

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
