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

"""Old name of :mod:`uav_tracking_mpc.dynamics.frames`, where ``wrap_angle`` is; gone with 0.4."""

import warnings

from uav_tracking_mpc.dynamics.frames import wrap_angle as wrap_angle

warnings.warn(
    "uav_tracking_mpc.dynamics.angles is uav_tracking_mpc.dynamics.frames now: import from there",
    DeprecationWarning,
    stacklevel=2,
)
