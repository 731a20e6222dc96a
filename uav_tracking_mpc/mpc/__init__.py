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

=====================  ================================================================
``problem``            any problem of this kind: dynamics, costs, box, inequalities
``quadratic``          (14)-(16) of the paper: quadratic costs, terminal ellipsoid
``solution``           what comes back: a status in words, cost, plan, time
``solver``             the interface that every solver shares
``plan_guesses``       plans to begin from: the last one moved on, or cold ones
``optimality``         cost and KKT residual of a plan, whoever found it
``nonlinear_program``  the problem as variables, bounds and constraints
``casadi_solver``      the problem handed to fatrop or IPOPT through CasADi
``newton_solver``      the problem solved by a stagewise Newton method, compiled for it
``newton``             that method, one idea a file
``cold_start``         the guesses from which a cold solve tries it
``stage_code``         the problem's equations and derivatives as straight-line code
``compiled_method``    the method as machine code, loaded from the cache
``method_cache``       where compiled methods are kept, and under which name
``machine_code``       makes the machine code, as a process of its own
``compilation``        that process, waited for or given up
``bridged_solver``     another solver solves until the compiled one can
``prediction_loop``    the closed loop on the prediction model itself, for campaigns
=====================  ================================================================
"""
