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

"""Monte-Carlo over what is uncertain: many flights of one file, and what they have in common.

======================  ==============================================================
``distribution``        how a value is drawn
``uncertain_inputs``    what can be uncertain: parameters, and what is derived from them
``campaign_file``       the YAML that describes a campaign, checked
``criteria``            when a flight has failed
``flight_plan``         what each flight meets
``one_flight``          a flight, from its number to a row of the results
``executors``           processes of this machine, or a Dask cluster
``flight_store``        results on disk: batches, then one Parquet file
``campaign_run``        all of it, resumable
``failure_statistics``  probabilities with exact bounds, and what failures have in common
``campaign_results``    the campaign as one object for JSON
``campaign_tables``     tables for the terminal and for pages
``campaign_figure``     the picture of a campaign
``campaign_page``       the folder with page, picture and the worst flights
======================  ==============================================================
"""
