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

"""Terminal ingredients of the paper's problem, proof that they do what they are for, certificates.

=====================  =============================================================================
``stability_problem``  what the analysis is about: model, orbit, weights, input set
``ingredients``        K of (24), P_rho of (28), and how large a level U allows
``theorems``           Theorems 2 and 3 as they are written, quantity by quantity
``direct_condition``   what makes x'P_rho x <= varrho a terminal set; its proof
``admissible``         linear limits on the ellipsoid
``quadratic_bound``    the one kind of inequality that has to be proved, as data
``terminal_dynamics``  the closed loop f(x, Kx) with its derivatives
``ball``               CasADi functions in ball arithmetic
``cover``              a proof: halve boxes until each one passes its test
``box_check``          the test of one box
``box_guess``          good guesses for it, which need not be right
``violation``          search for counterexamples
``certificate``        a proof written down
``verify``             the independent checker of certificates
``box_verification``   its test of boxes
``interval_matrix``    its linear algebra
``interval``           its arithmetic
``claim``              certified, sampled, or neither
``status``             which of the three holds of a configuration
``decrease``           whether the optimal cost falls in flight as (54) says
=====================  =============================================================================
"""
