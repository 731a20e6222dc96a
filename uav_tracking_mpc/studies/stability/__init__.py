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
``stability_study``     everything below, for one configuration
``analysis``            Section 5 for one configuration
``analysis_text``       the analysis as JSON and in words
``printed``             what the paper prints
``distance_budget``     what can be flown at all in N steps
``paper_cases``         the paper's problem recomputed in three ways
``paper_report``        the paper beside the truth
``paper_report_text``   this report as a table and as a page
``ellipsoid_campaign``  what was proved, flown
``attraction``          maps of X_N (20)
``design``              rho and weights for the largest certified region
``stability_figures``   pictures
======================  ==========================================================================

Proving needs python-flint (``pip install python-flint``, extra ``proof``); checking a certificate,
the status of a configuration and the online check do not.
"""
