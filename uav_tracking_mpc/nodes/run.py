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

"""Start a node, spin it, stop it; exit codes as in docs/reference/command_line.md."""

from __future__ import annotations

import gc
import logging
import shlex
import signal
import sys
from collections.abc import Callable, Sequence
from itertools import takewhile
from types import FrameType

import rclpy
from rclpy.exceptions import ParameterException
from rclpy.experimental.events_executor import EventsExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from rclpy.utilities import remove_ros_args

from uav_tracking_mpc.nodes.log_folder import ensure_log_folder
from uav_tracking_mpc.nodes.node_help import help_text
from uav_tracking_mpc.nodes.qos_overrides import warn_of_vain_overrides
from uav_tracking_mpc.parameters.specification import ParameterError

# Arguments of ROS that a word follows.
ROS_FLAGS = {
    *("-p", "--param", "-r", "--remap", "--params-file"),
    *("-e", "--enclave", "--log-level", "--log-config-file"),
}


def run(name: str, create: Callable[[], Node], arguments: Sequence[str] | None = None) -> int:
    """Run a node until SIGINT or SIGTERM.

    The signals are handled here, not by rclpy, so that the node can publish its last
    diagnostics (``node.finish()``) before the context is shut down.

    A node that cannot go on says why in ``node.refusal``.

    Args:
        name: For messages before there is a logger.
        create: Makes the node.
        arguments: Command line without the program, sys.argv by default.

    Returns:
        Exit code.
    """
    stopped = False

    def stop(signum: int, frame: FrameType | None) -> None:
        nonlocal stopped
        stopped = True

    previous = {number: signal.signal(number, stop) for number in (signal.SIGINT, signal.SIGTERM)}
    node: Node | None = None
    logging.basicConfig(
        level=logging.INFO, format=f"[%(levelname)s] [{name}]: %(message)s", stream=sys.stderr
    )
    try:
        arguments = list(sys.argv[1:] if arguments is None else arguments)
        if {"-h", "--help"} & set(takewhile(lambda word: word != "--ros-args", arguments)):
            print(help_text(name, _described(create)))
            return 0
        try:
            refused = refusal(name, arguments)
            if refused:
                return _fatal(name, refused)
            if changed := ensure_log_folder():
                logging.getLogger(__name__).info(changed)
            rclpy.init(args=[name, *arguments], signal_handler_options=SignalHandlerOptions.NO)
        except Exception as error:  # rclpy has no common base for what a command line can do wrong
            return _fatal(name, str(error))
        node = create()
        warn_of_vain_overrides(node)
        # What exists now lives as long as the node: the collector need not look at it again, which
        # would take tens of milliseconds in the middle of a flight.
        gc.collect()
        gc.freeze()
        executor = EventsExecutor()
        executor.add_node(node)
        while rclpy.ok() and not stopped:
            executor.spin_once(timeout_sec=0.1)
            if words := getattr(node, "refusal", ""):
                return _fatal(name, words)
        finish = getattr(node, "finish", None)
        if finish is not None and rclpy.ok():
            finish()
        return 0
    except (ParameterError, ParameterException) as error:
        return _fatal(name, str(error))
    except ImportError as error:  # of what a parameter asks for, such as JSBSim
        if (error.name or "").startswith("uav_tracking_mpc"):
            raise
        return _fatal(name, str(error))
    finally:
        if node is not None:
            node.destroy_node()
        rclpy.try_shutdown()
        for number, handler in previous.items():
            # The process ends: whoever signals it once more must not break that off.
            signal.signal(number, signal.SIG_IGN if stopped else handler)


def refusal(name: str, arguments: Sequence[str]) -> str:
    """Why a node does not start with these arguments, in words; "" if it does.

    ROS reads only what stands behind ``--ros-args`` and ignores everything else without a word: a
    node would fly with its defaults instead of the file that it was given.

    Args:
        name: Name of the executable, for the right spelling.
        arguments: Command line without the program.
    """
    stray = remove_ros_args([name, *arguments])[1:]
    if not stray:
        return ""
    words: list[str] = []
    for previous, word in zip(["", *stray], stray, strict=False):
        if ":=" in word and previous not in ROS_FLAGS:
            words.append("-p")
        elif word not in ROS_FLAGS and previous not in ROS_FLAGS:
            words = ["-p", "NAME:=VALUE", "--params-file", "FILE"]  # no argument of ROS at all
            break
        words.append(word)
    right = " ".join([name, "--ros-args", *words])
    return f"what is not behind --ros-args has no effect: {shlex.join(stray)}; write: {right}"


def _described(create: Callable[[], Node]) -> str:
    """What a node does: the first line of its module, without its name."""
    words = sys.modules[create.__module__].__doc__ or ""
    does = words.partition("\n")[0].partition(": ")[2]
    return does[:1].upper() + does[1:]


def _fatal(name: str, message: str) -> int:
    line = " ".join(message.split())
    print(f"[FATAL] [{name}]: {line}", file=sys.stderr, flush=True)
    return 2
