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

"""Whether a folder can be written, asked before hours of work go into it."""

from __future__ import annotations

import tempfile
from pathlib import Path

from uav_tracking_mpc.parameters.specification import ParameterError


def check_writable(folder: Path) -> None:
    """Make sure that files can be written into a folder; nothing of the trial is left behind.

    Args:
        folder: That will be written; it need not be there yet.

    Raises:
        ParameterError: They cannot be.
    """
    missing = [place for place in (folder, *folder.parents) if not place.exists()]
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        reason = "it is a file" if folder.is_file() else error.strerror or str(error)
        raise ParameterError(
            f"--output is {str(folder)!r}, must be a folder that can be written: {reason}"
        ) from error
    finally:
        for made in missing:
            if made.is_dir():
                made.rmdir()
