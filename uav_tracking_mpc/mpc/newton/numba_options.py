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
placed = njit(**OPTIONS, inline="always")  # into its caller, not compiled by itself
entry = njit(**OPTIONS, no_cfunc_wrapper=True, nogil=True)
