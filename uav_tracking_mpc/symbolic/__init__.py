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

"""CasADi's tools, whatever they are used for.

===============  ===============================================================================
``functions``    built by one thread at a time, on arrays of their own, walked through; time steps
``layout``       names for the parts of a flat vector
``code_cache``   where machine code is kept
``native_code``  functions as machine code, with the same numbers
===============  ===============================================================================
"""
