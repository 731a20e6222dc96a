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

"""Nodes as real processes, for tests."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import sys

DOMAIN = os.environ["DOMAIN_OF_PROCESSES"]  # this worker's: test/conftest.py


def command(module, *arguments):
    return [sys.executable, "-m", f"uav_tracking_mpc.{module}", *arguments]


def environment():
    return {**os.environ, "ROS_DOMAIN_ID": DOMAIN}


def undecided():
    """The same for a launcher that is to find a free domain by itself."""
    return {key: value for key, value in os.environ.items() if key != "ROS_DOMAIN_ID"}


def run_node(name, *arguments, stop=None, after="", limit=120.0):
    """Run a node; send ``stop`` once its output holds ``after``. Returns exit code and output."""
    process = subprocess.Popen(
        command(f"nodes.{name}", *arguments),
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        env=environment(),
    )
    output = ""
    try:
        if stop is not None:
            assert process.stdout is not None
            for line in process.stdout:
                output += line
                if after in line:
                    break
            process.send_signal(stop)
        output += process.communicate(timeout=limit)[0]
    finally:
        with contextlib.suppress(ProcessLookupError):
            process.kill()
    return process.returncode, output


def nodes_of(launcher):
    """Process ids of a launcher's nodes, by name."""
    children = subprocess.run(
        ["ps", "-ww", "-o", "pid=,args=", "--ppid", str(launcher)], capture_output=True, text=True
    ).stdout
    found = {}
    for line in children.splitlines():
        identity, _, words = line.strip().partition(" ")
        if "uav_tracking_mpc.nodes." in words:
            found[words.split("uav_tracking_mpc.nodes.")[1].split()[0]] = int(identity)
    return found


def alive(identity):
    try:
        os.kill(identity, 0)
    except ProcessLookupError:
        return False
    return True


INTERRUPT, TERMINATE, KILL = signal.SIGINT, signal.SIGTERM, signal.SIGKILL
