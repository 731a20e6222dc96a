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

"""The optimal control problem (14)-(16) as data, and its solvers. Knows nothing of aircraft.

===================  ============================================================================
``problem``          any problem of this kind; (14)-(16) of the paper: quadratic, with an ellipsoid
``solver``           the interface that every solver shares, what a solve gives back, its flights
``casadi_solver``    the problem as a nonlinear program, handed to IPOPT through CasADi
``newton_solver``    the problem solved by a stagewise Newton method, from warm and cold starts
``newton``           that method, to be compiled for the problem
``stage_code``       the problem's equations and derivatives as straight-line code
``machine_code``     makes the method's machine code, as a process of its own
``compiled_method``  keeps the machine code, waits for it, loads it
``bridged_solver``   another solver solves until the compiled one can
===================  ============================================================================
"""
