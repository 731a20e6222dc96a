"""Start a node, spin it, stop it; exit codes 0 (stopped), 1 (died), 2 (bad arguments)."""

from __future__ import annotations

import gc
import logging
import shlex
import signal
import sys
from collections.abc import Callable, Sequence
from types import FrameType

import rclpy
from rclpy.exceptions import ParameterException
from rclpy.experimental.events_executor import EventsExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from rclpy.utilities import remove_ros_args

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
        try:
            refused = refusal(name, arguments)
            if refused:
                return _fatal(name, refused)
            rclpy.init(args=[name, *arguments], signal_handler_options=SignalHandlerOptions.NO)
        except Exception as error:  # rclpy has no common base for what a command line can do wrong
            return _fatal(name, str(error))
        node = create()
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
    finally:
        if node is not None:
            node.destroy_node()
        rclpy.try_shutdown()
        for number, handler in previous.items():
            signal.signal(number, handler)


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


def _fatal(name: str, message: str) -> int:
    line = " ".join(message.split())
    print(f"[FATAL] [{name}]: {line}", file=sys.stderr, flush=True)
    return 2
