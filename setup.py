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

"""Package metadata. It stays here: a [project] table in pyproject.toml breaks the colcon build."""

from glob import glob
from pathlib import Path

from setuptools import find_packages, setup

NAME = "uav_tracking_mpc"
# With `colcon build --symlink-install` this file is a link in build/; what it reads is not there.
ROOT = Path(__file__).resolve().parent

setup(
    name=NAME,
    version="0.3.0",
    description="Nonlinear MPC of a fixed-wing UAV that circles a ground target in 3-D",
    long_description=(ROOT / "README.md").read_text(encoding="utf-8"),
    long_description_content_type="text/markdown",
    url="https://github.com/uav-tracking-mpc/uav_tracking_mpc",
    author="uav_tracking_mpc maintainers",
    author_email="maintainers@example.org",
    maintainer="uav_tracking_mpc maintainers",
    maintainer_email="maintainers@example.org",
    license="Apache-2.0",
    python_requires=">=3.10",
    # The configurations lie in config/, where ROS users look, and travel inside the package, where
    # they are found however it was installed.
    packages=[*find_packages(include=[NAME, f"{NAME}.*"]), f"{NAME}.config"],
    package_dir={f"{NAME}.config": "config"},
    package_data={
        f"{NAME}.config": [
            "*.yaml",
            "*.xml",
            "certificates/*.json",
            "campaigns/*.yaml",
            "scenarios/*.yaml",
            "airframes/*/*.xml",
            "security/*.xml",
        ],
        "": ["*.j2", "*.js", "*.css", "py.typed"],
    },
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{NAME}"]),
        (f"share/{NAME}", ["package.xml"]),
        (f"share/{NAME}/config", glob("config/*.yaml") + glob("config/*.xml")),
        (f"share/{NAME}/config/airframes/aerosonde", glob("config/airframes/aerosonde/*.xml")),
        (f"share/{NAME}/config/campaigns", glob("config/campaigns/*.yaml")),
        (f"share/{NAME}/config/certificates", glob("config/certificates/*.json")),
        (f"share/{NAME}/config/scenarios", glob("config/scenarios/*.yaml")),
        (f"share/{NAME}/config/security", glob("config/security/*.xml")),
        (f"share/{NAME}/launch", glob("launch/*.launch.py")),
        (f"share/{NAME}/rviz", glob("rviz/*.rviz")),
        (f"share/{NAME}/foxglove", glob("foxglove/*.json")),
    ],
    zip_safe=False,
    install_requires=[
        "argcomplete>=3.0",
        "casadi>=3.7",
        "jinja2>=3.0",
        "matplotlib>=3.6",
        "numba>=0.59",
        "numpy>=1.24",
        "pillow>=9.0",
        "pyyaml>=6.0",
        "rich>=13.0",
        "rosbags>=0.10.9",
        "scipy>=1.10",
    ],
    extras_require={
        # Never for machines with ROS 2 from apt: the two must not mix. The prefix names the
        # distribution; without it a later one is taken.
        "ros": ["ros-jazzy-rclpy[fastrtps]==7.1.6", "ros-jazzy-common-interfaces==5.3.6"],
        # Nothing any more: proofs of terminal sets need no library of their own.
        "proof": [],
        # Results of campaigns as Parquet; a Dask cluster to fly them on.
        "campaign": ["pyarrow>=14.0"],
        "dask": ["distributed>=2024.1"],
        # Links to autopilots, and the simulated one; a plant with six degrees of freedom.
        "mavlink": ["pymavlink>=2.4.41"],
        "jsbsim": ["jsbsim>=1.3"],
        # The live page, and bags by their index. What view/serving/guarded_server.py takes for
        # granted was looked up in viser 1.
        "view": ["mcap>=1.0", "trimesh>=4", "viser>=1.1,<2", "websockets>=13.1"],
        "test": [
            "colcon-common-extensions",
            "control>=0.10.2",
            "distributed>=2024.1",
            "duckdb>=0.10",
            "hypothesis",
            "jsbsim>=1.3",
            "mcap>=1.0",
            "mypy",
            "pandas>=2.0",
            "playwright>=1.40",
            "pyarrow>=14.0",
            "pymavlink>=2.4.41",
            "pytest",
            "pytest-rerunfailures",
            "pytest-xdist",
            "python-flint>=0.6",
            "ruff",
            "trimesh>=4",
            "types-PyYAML",
            "viser>=1.1,<2",
            "websockets>=15",
        ],
        "mutants": ["cosmic-ray>=8.4"],
        "docs": ["furo", "myst-parser>=4.0", "pyspellchecker>=0.8", "sphinx>=8.2"],
    },
    entry_points={
        "console_scripts": [
            f"uav_simulator = {NAME}.cli.node_programs:uav_simulator",
            f"target_publisher = {NAME}.cli.node_programs:target_publisher",
            f"nmpc_controller = {NAME}.cli.node_programs:nmpc_controller",
            f"autopilot_link = {NAME}.cli.node_programs:autopilot_link",
            f"monitor = {NAME}.cli.node_programs:monitor",
            f"launch_tracking = {NAME}.cli.launch_tracking:main",
            f"uav_tracking = {NAME}.cli.main:main",
        ]
    },
)
