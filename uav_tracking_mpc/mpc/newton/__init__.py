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

=====================  =============================================================================
``stage``              the problem: sizes, and the straight-line code of its equations (generated)
``straight_line``      turns that code into machine code
``workspace``          every array of the method, cut once from one buffer
``multipliers``        augmented Lagrangian: constraints become part of the merit
``backward_sweep``     costates and Riccati recursion: gradient, Newton step and gains, stage N to 0
``input_box``          the small quadratic program over the inputs of one stage
``rollout``            forward simulation under the step: the dynamics hold exactly at every iterate
``warm_start``         the kept plan moved on in time
``attempt``            from one guess: sweep, line search, multiplier update, stopping
``openings``           the guesses of a cold start: held inputs, then feedback to the goal
``minimise``           the entry: one attempt, or one from every opening
``clock``              wall time inside compiled code
``numba_options``      how each function is compiled
=====================  =============================================================================

The files import each other relatively because they are compiled as a copy: a folder in the user's
cache that holds them beside the ``stage.py`` of the problem at hand. The ``stage.py`` kept here is
that of an integrator, so that everything can be read, type-checked and run in place.
"""
