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

"""Reproduce the paper: fly Section 6 as published, and see where its certificate fails.

Prints the figures of the flight and the entries of the paper's Section 4 beside what is true, and
writes the paper's Figures 2 and 3 to the folder given (default: output/paper).
"""

import sys
from pathlib import Path

from uav_tracking_mpc.cli.main import main

if __name__ == "__main__":
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else "output/paper")
    code = main(["simulate", "--config", "paper", "--output", str(folder)])
    print(f"Figures 2 and 3: {folder / 'trajectory.png'}, {folder / 'states.png'}")
    sys.exit(code or main(["stability", "--config", "paper", "--output", str(folder)]))
