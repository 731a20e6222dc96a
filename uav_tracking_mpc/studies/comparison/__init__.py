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

"""The predictive controller beside other laws, through the same scenarios.

======================  ==============================================================
``law_names``           which laws there are
``flights``             every law through every scenario, in processes
``mismatches``          what may be other than the controller was told, by name
``measures``            what counts of a flight, from the truth and the limits alone
``targets``             what the predictive controller is to reach, and whether it does
``mismatch_targets``    what it is to hold under a mismatch, and whether it does
``results``             the comparison, and all of it as one object for JSON
``mismatch_results``    the flights under mismatches as one object for JSON
``comparison_table``    the table of the scenarios
``mismatch_table``      the table of the mismatches
``comparison_figures``  a picture of each scenario and a summary
``mismatch_figure``     a picture of all mismatches
``comparison_page``     the page that holds table and pictures
======================  ==============================================================
"""
