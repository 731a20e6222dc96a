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

"""Who may open a page, and where it listens.

==================  ================================================================================
``guarded_server``  viser's server, which answers to whom it should, and its address
``page_script``     puts the script of the page, title and icon into what viser serves or records;
                    the script is ``page_script.js``, its looks ``page_style.css``
``browser``         opens a page where there is a screen
==================  ================================================================================
"""
