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

"""Terminal ingredients of the paper's problem that are flown, and the checker of certificates.

===================  ===========================================================================
``ingredients``      model, orbit, weights, input set; K of (24), P_rho of (28), levels U allows
``certificate``      a proof written down, and its checker, which believes nothing of a search
``quadratic_bound``  the one kind of inequality that has to be proved, tested on boxes
``interval``         arithmetic and linear algebra of it: intervals, rounded outwards
``decrease``         whether the optimal cost falls in flight as (54) says
===================  ===========================================================================
"""
