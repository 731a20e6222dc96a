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

"""Stagewise Newton method for :class:`~uav_tracking_mpc.mpc.problem.OptimalControlProblem`.

The algorithm, one idea a file, in the order in which an iteration runs through them:

==================  ================================================================================
``stage``           the problem: sizes, and the straight-line code of its equations (generated)
``compiling``       how functions are compiled, and what turns that code into machine code
``workspace``       every array of the method, cut once from one buffer
``lagrangian``      rollout, and the augmented Lagrangian: constraints become part of the merit
``backward_sweep``  costates and Riccati recursion: gradient, Newton step and gains, stage N to 0
``minimise``        the entry: warm start, openings, and an attempt: sweep, line search, multipliers
==================  ================================================================================

The files import each other relatively because they are compiled as a copy: a folder in the user's
cache that holds them beside the ``stage.py`` of the problem at hand. The ``stage.py`` kept here is
that of an integrator, so that everything can be read, type-checked and run in place.
"""
