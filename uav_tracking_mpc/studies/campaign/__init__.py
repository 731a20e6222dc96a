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

"""Many flights of what is uncertain, and how many of them fail.

====================  ====================================================================
``campaign_file``     the YAML that describes a campaign, what it draws, and when flights fail
``uncertain_inputs``  what can be uncertain: parameters, and what is derived from them
``campaign_run``      flights from their number to a row, kept on disk, resumable
``campaign_results``  probabilities with exact bounds, what failures share; as a study
====================  ====================================================================
"""
