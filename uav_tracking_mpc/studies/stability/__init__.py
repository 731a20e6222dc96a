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

"""The paper's Section 5 as a report: what is wrong in it, what is proved, what flights show.

======================  ==========================================================================
``stability_study``     everything below, for one configuration: JSON, words, pictures; its design:
                        rho and weights for the largest certified region
``analysis``            Theorems 2 and 3, states that break what they need, the levels, the proof
``proof``               what makes x'P_rho x <= varrho a terminal set; its proof, its certificate
``paper_report``        what the paper prints beside the truth, as a table and as a page
``stability_campaign``  maps of X_N (20); what was proved, flown
======================  ==========================================================================
"""
