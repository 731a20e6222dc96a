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

"""The moving picture of a flight."""

from itertools import pairwise

from example_flights import moving_target
from PIL import Image, ImageChops

from uav_tracking_mpc.report.animation import save_animation


def test_pictures_follow_each_other(tmp_path):
    path = tmp_path / "flight.gif"
    save_animation(moving_target(), path, frames=4)
    assert path.stat().st_size < 1_000_000
    with Image.open(path) as animation:
        assert animation.n_frames == 4
        pictures = []
        for index in range(4):
            animation.seek(index)
            pictures.append(animation.convert("RGB"))
    for one, other in pairwise(pictures):
        assert ImageChops.difference(one, other).getbbox() is not None
