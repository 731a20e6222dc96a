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

"""Directive ``command-help``: what a command prints with ``--help``, asked at every build."""

import os
import subprocess
import sys

from docutils import nodes
from sphinx.util.docutils import SphinxDirective

WIDTH = "88"  # characters


class CommandHelp(SphinxDirective):
    """The help of ``uav_tracking`` or of one of its commands, named by the arguments."""

    optional_arguments = 2  # a command, and an action of it

    def run(self):
        """Ask the command."""
        program = [sys.executable, "-m", "uav_tracking_mpc", *self.arguments, "--help"]
        environment = {**os.environ, "COLUMNS": WIDTH, "NO_COLOR": "1"}
        finished = subprocess.run(program, capture_output=True, text=True, env=environment)
        if finished.returncode != 0:
            raise self.error(f"{program}: {finished.stderr}")
        return [nodes.literal_block(finished.stdout, finished.stdout, language="text")]


def setup(app):
    """Register the directive."""
    app.add_directive("command-help", CommandHelp)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}
