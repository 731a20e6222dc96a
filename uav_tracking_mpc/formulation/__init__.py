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

"""The tracking problem, posed in two ways, over a prediction model and limits.

======================  ================================================================
``formulation``         what a way to pose the problem offers the controller
``flight_problem``      drift, lag, limits and an artificial orbit as a problem
``flight_formulation``  the flight problem, fed with parameters, situation and forecast
``paper_formulation``   the paper's problem (14)-(16), and the same fed with a situation
======================  ================================================================
"""
