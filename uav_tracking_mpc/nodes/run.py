"""Start a node, spin it, stop it; exit codes 0 (stopped), 1 (died), 2 (bad parameters)."""

from __future__ import annotations

import gc
import logging
import signal
import sys
from collections.abc import Callable, Sequence
from types import FrameType

import rclpy
from rclpy.exceptions import ParameterException
from rclpy.experimental.events_executor import EventsExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

from uav_tracking_mpc.parameters.specification import ParameterError


def run(name: str, create: Callable[[], Node], arguments: Sequence[str] | None = None) -> int:
    """Run a node until SIGINT or SIGTERM.

    The signals are handled here, not by rclpy, so that the node can say its last words
    (``node.finish()``) while it can still publish.

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
        arguments = sys.argv[1:] if arguments is None else arguments
        try:
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


def _fatal(name: str, message: str) -> int:
    line = " ".join(message.split())
    print(f"[FATAL] [{name}]: {line}", file=sys.stderr, flush=True)
    return 2
