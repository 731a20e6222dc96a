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

"""A bag on a page; what no bag is says :mod:`test_bag`, what shows no flight the source."""


def test_what_is_no_bag_is_one_line(tmp_path, uav_tracking):
    bag = tmp_path / "flight.mcap"
    bag.touch()
    assert uav_tracking.refused("view", bag) == f"uav_tracking: bag {bag} is empty: 0 bytes\n"
