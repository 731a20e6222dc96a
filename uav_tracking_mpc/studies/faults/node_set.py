"""The node processes of a campaign: started with the relay between them, stopped, killed."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

from rich.console import Console

from uav_tracking_mpc.launch.node_process import NodeProcess
from uav_tracking_mpc.launch.shared_memory import SharedMemoryFiles
from uav_tracking_mpc.settings.configuration import Configuration
from uav_tracking_mpc.studies.faults.fault_kinds import NODES

RELAY_NODE = "fault_relay"
# Ends by itself, for nobody ends it when the campaign itself is killed.
BURNER = "import time\nend = time.monotonic() + 10.0\nwhile time.monotonic() < end: pass"
REMAPS = {  # what each node sends goes to the relay first
    "uav_simulator": ("uav/odometry", "uav/air_velocity", "/clock"),
    "target_publisher": ("target/position",),
    "nmpc_controller": ("uav/command",),
}


class Crew:
    """Processes by name.

    Args:
        configuration: What they fly.
        speed: Simulated over wall time.
        parameters: File to write the nodes' parameters to.
        console: Where their output goes.
    """

    def __init__(
        self, configuration: Configuration, speed: float, parameters: Path, console: Console
    ) -> None:
        self._speed, self._parameters, self._console = speed, parameters, console
        parameters.write_text(configuration.yaml(), encoding="utf-8")
        self._files = SharedMemoryFiles()
        self._burners: list[subprocess.Popen[bytes]] = []
        self.processes: dict[str, NodeProcess] = {}
        self.started: dict[str, float] = {}  # steady time [s]

    def start_all(self) -> None:
        """Start relay and nodes."""
        for name in (RELAY_NODE, *NODES):
            self.start(name)

    def start(self, name: str) -> None:
        """Start a node, for the first time or again."""
        room = "torture" if name == RELAY_NODE else "nodes"
        self.processes[name] = NodeProcess(name, self._arguments(name), self._console, room)
        self.started[name] = time.monotonic()

    def _arguments(self, name: str) -> list[str]:
        if name == RELAY_NODE:
            return []
        arguments = ["--ros-args", "--params-file", str(self._parameters)]
        for topic in REMAPS[name]:
            prefix = "/raw" if topic.startswith("/") else "raw/"
            arguments += ["-r", f"{topic}:={prefix}{topic}"]
        if name == "uav_simulator":  # the listeners are relay and observer
            assignments = ["publish_clock:=true", "wait_for_subscribers:=2"]
            assignments += ["start_on_command:=true", f"speed:={self._speed!r}"]
        else:
            assignments = ["use_sim_time:=true"]
        for assignment in assignments:
            arguments += ["-p", assignment]
        return arguments

    def note_files(self) -> None:
        """Remember the shared-memory files in use: a killed process cannot remove its own."""
        identities = [process.identity for process in self.processes.values()]
        self._files.note([os.getpid(), *identities])

    def kill(self, name: str) -> None:
        """Kill -9; until it is started again it is nobody's loss."""
        self.note_files()
        self.processes.pop(name).stop(signal.SIGKILL)

    def freeze(self, name: str) -> None:
        """SIGSTOP."""
        self.processes[name].send_signal(signal.SIGSTOP)

    def thaw(self, name: str) -> None:
        """SIGCONT."""
        self.processes[name].send_signal(signal.SIGCONT)

    def burn(self) -> None:
        """Start two busy processes for every core."""
        program = [sys.executable, "-S", "-c", BURNER]
        self._burners += [
            subprocess.Popen(program, stdin=subprocess.DEVNULL)
            for _ in range(2 * (os.cpu_count() or 1))
        ]

    def extinguish(self) -> None:
        """End them."""
        for burner in self._burners:
            burner.kill()
            burner.wait()
        self._burners.clear()

    def dead(self) -> dict[str, int]:
        """Exit codes of those that have ended."""
        codes = {name: process.exit_code for name, process in self.processes.items()}
        return {name: code for name, code in codes.items() if code is not None}

    def end(self) -> None:
        """End everything."""
        self.extinguish()
        self.note_files()
        for process in self.processes.values():
            process.send_signal(signal.SIGCONT)
            process.send_signal(signal.SIGTERM)
        for process in self.processes.values():
            process.stop(signal.SIGTERM)

    def clean(self) -> None:
        """Remove the shared-memory files of the killed, when ROS is shut down here as well."""
        self._files.remove_orphans()
