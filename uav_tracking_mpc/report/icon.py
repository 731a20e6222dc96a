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

"""The picture in the tab of every page: an aircraft that circles a target."""

from __future__ import annotations

from urllib.parse import quote

ICON = (
    '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 32 32">'
    '<rect width="32" height="32" rx="7" fill="#0b3a5b"/>'
    '<circle cx="16" cy="16" r="10.5" fill="none" stroke="#56b4e9" stroke-width="2" '
    'stroke-dasharray="4 2.6"/><circle cx="16" cy="16" r="2.4" fill="#e69f00"/>'
    '<path d="M26.5 5.2 22 14.2l-2.6-3.4-4.2-1z" fill="#fff"/></svg>'
)
ICON_ADDRESS = f"data:image/svg+xml,{quote(ICON)}"
