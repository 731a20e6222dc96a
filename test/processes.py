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

"""Nodes as processes, and waits for events: what has not come in five minutes does not come."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

INTERRUPT, TERMINATE, KILL = signal.SIGINT, signal.SIGTERM, signal.SIGKILL
DOMAIN = os.environ["DOMAIN_OF_PROCESSES"]  # this worker's: test/conftest.py
# s; for what is broken, not a measure of what works. Two waits end before a test counts as hung.
PATIENCE = 300.0


def wait_for(condition, limit=PATIENCE):
    """Whether a condition comes to hold."""
    return _until(condition, limit, lambda: time.sleep(0.02))


def spin(executor, until, limit=PATIENCE, also=lambda: None):
    """Whether a condition comes to hold while an executor of rclpy spins, and something is done."""
    return _until(until, limit, lambda: (executor.spin_once(timeout_sec=0.02), also()))


def _until(condition, limit, meanwhile):
    deadline = time.monotonic() + limit
    while True:
        meanwhile()
        if condition():
            return True
        if time.monotonic() >= deadline:
            return False


def command(module, *arguments):
    return [sys.executable, "-m", f"uav_tracking_mpc.{module}", *arguments]


def environment():
    return {**os.environ, "ROS_DOMAIN_ID": DOMAIN}


def undecided():
    """The same for a launcher that is to find a free domain by itself."""
    return {key: value for key, value in os.environ.items() if key != "ROS_DOMAIN_ID"}


@contextlib.contextmanager
def started(module, *arguments, after="", env=None, apart=False):
    """A process that has said ``after``, among its errors alone where they are kept apart.

    What it has said by then is its attribute ``said``. It is killed in the end.
    """
    process = subprocess.Popen(
        command(module, *map(str, arguments)),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE if apart else subprocess.STDOUT,
        text=True,
        env=environment() if env is None else env,
    )
    try:
        process.said, process.lines = "", process.stderr if apart else process.stdout
        hear(process, after)
        yield process
    finally:
        process.kill()
        process.wait()


def hear(process, words):
    """Read what a started process says until it has said some words, or says no more."""
    while words not in process.said and (line := process.lines.readline()):
        process.said += line


def ended(process, stop=None, limit=900.0):
    """Exit code and output of a process that ends, by a signal or by itself."""
    if stop is not None:
        process.send_signal(stop)
    rest = process.communicate(timeout=limit)[0]
    return process.returncode, process.said + rest


def outcome(module, *arguments, **how):
    """Exit code, output and errors of a process that ends by itself."""
    return _outcome(command(module, *map(str, arguments)), **how)


def scripted(program, *arguments, missing=(), **how):
    """The same of a program in Python that finds some modules missing."""
    program = f"import sys; sys.modules.update(dict.fromkeys({missing!r}))\n{program}"
    return _outcome([sys.executable, "-c", program, *map(str, arguments)], **how)


def _outcome(words, env=None, limit=900.0):
    env = environment() if env is None else env
    finished = subprocess.run(words, capture_output=True, text=True, env=env, timeout=limit)
    return finished.returncode, finished.stdout, finished.stderr


def run(module, *arguments, stop=None, after="", env=None):
    """Exit code and output of a process, to which ``stop`` is sent after it has said ``after``."""
    with started(module, *arguments, after=after, env=env) as process:
        return ended(process, stop if after in process.said else None)


def run_node(name, *arguments, **how):
    return run(f"nodes.{name}", *arguments, **how)


def fatal_words(name, code, output):
    """Why a node could not start: the one line with which it ended, in code 2, without its name."""
    fatal = [line for line in output.splitlines() if line.startswith("[FATAL]")]
    assert code == 2, output
    assert len(fatal) == 1, output
    assert "Traceback" not in output
    assert fatal[0].startswith(f"[FATAL] [{name}]: ")
    return fatal[0].removeprefix(f"[FATAL] [{name}]: ")


def refused_start(name, *arguments):
    """Why a process of a node does not start with arguments of ROS."""
    return fatal_words(name, *run_node(name, "--ros-args", *arguments))


def children_of(parent):
    """Process ids of children, and with which words they were started."""
    listed = subprocess.run(
        ["ps", "-ww", "-o", "pid=,args=", "--ppid", str(parent)], capture_output=True, text=True
    ).stdout
    for line in listed.splitlines():
        identity, _, words = line.strip().partition(" ")
        yield int(identity), words


def nodes_of(launcher):
    """Process ids of a launcher's nodes, by name."""
    room = "uav_tracking_mpc.nodes."
    return {
        words.split(room)[1].split()[0]: identity
        for identity, words in children_of(launcher)
        if room in words
    }


def alive(identity):
    """Whether a process runs; one that has ended and that nobody has waited for does not."""
    try:
        state = Path(f"/proc/{identity}/stat").read_text().rpartition(")")[2].split()[0]
    except (FileNotFoundError, ProcessLookupError):
        return False
    return state not in "ZX"
