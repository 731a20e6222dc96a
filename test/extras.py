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

"""Imports of what only some commands need: extras of setup.py, which a ROS machine may lack."""

EXTRAS = {
    "acados_template", "control", "cosmic_ray", "dask", "distributed", "duckdb", "flint", "jsbsim",
    "mcap", "msgspec", "pandas", "playwright", "pyarrow", "pymavlink", "serial", "trimesh", "viser",
    "websockets", "zstandard",
}  # fmt: skip


def missing_extra(error: BaseException | None) -> str | None:
    """Name of the extra whose absence an error tells of, by itself or by one of its causes."""
    while error is not None:
        name = (getattr(error, "name", None) or "").partition(".")[0]
        if isinstance(error, ImportError) and name in EXTRAS:
            return name
        error = error.__cause__ or error.__context__
    return None
