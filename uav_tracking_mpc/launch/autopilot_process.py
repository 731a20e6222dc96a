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

"""A simulated autopilot as a process, at a place that no other program uses."""

from __future__ import annotations

import signal
import socket
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from rich.console import Console

from uav_tracking_mpc.launch.node_process import NodeProcess
from uav_tracking_mpc.settings.configuration import Configuration

MODULE = "uav_tracking_mpc.cli.main"


@contextmanager
def autopilot_process(configuration: Configuration, console: Console) -> Iterator[str]:
    """Fly a simulated autopilot of the link's kind while the context lasts.

    Args:
        configuration: Its section ``uav_simulator`` is what flies, ``autopilot_link`` says how the
            autopilot behaves.
        console: Where its output goes.

    Yields:
        The connection at which the link finds it.
    """
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("127.0.0.1", 0))
        place = f"127.0.0.1:{free.getsockname()[1]}"
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / f"{configuration.name}.yaml"
        file.write_text(configuration.yaml(), encoding="utf-8")
        arguments = ["autopilot", "--dialect", configuration.link.link]
        arguments += ["--config", str(file), "--connection", f"udpout:{place}"]
        if configuration.link.origin:
            # One word: South of the equator two would look like an option.
            arguments.append("--origin=" + ",".join(map(str, configuration.link.origin)))
        process = NodeProcess("autopilot", MODULE, arguments, console)
        try:
            yield f"udpin:{place}"
        finally:
            process.stop(signal.SIGTERM)
