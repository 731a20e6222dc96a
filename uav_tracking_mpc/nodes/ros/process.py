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
import re
import shlex
import signal
import sys
import threading
from collections.abc import Callable, Mapping, Sequence
from itertools import pairwise, takewhile
from pathlib import Path
from typing import Any, Generic, TypeVar

import rclpy
from rclpy.context import Context
from rclpy.exceptions import ParameterException
from rclpy.experimental.events_executor import EventsExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from rclpy.utilities import remove_ros_args

from uav_tracking_mpc.nodes.ros.endpoints import warn_of_vain_overrides
from uav_tracking_mpc.nodes.ros.node_reference import help_text
from uav_tracking_mpc.nodes.ros.rclpy_internals import refuse_negative_time
from uav_tracking_mpc.nodes.ros.ros_environment import (
    ensure_log_folder,
    exported_domain,
    refusal_of_ros,
)
from uav_tracking_mpc.parameters.specification import ParameterError
from uav_tracking_mpc.settings.configuration import SCENARIO, SECTIONS, read_yaml

# Arguments of ROS that a word follows.
ROS_FLAGS = {
    *("-p", "--param", "-r", "--remap", "--params-file"),
    *("-e", "--enclave", "--log-level", "--log-config-file"),
}


def run(name: str, create: Callable[[], Node], arguments: Sequence[str] | None = None) -> int:
    """Run a node until SIGINT or SIGTERM.

    The signals are handled here, not by rclpy, so that the node can publish its last
    diagnostics and let go of what it holds (``node.finish()``) before the context is shut down;
    it does so whatever ended it.

    A node that cannot go on says why in ``node.refusal``.

    Args:
        name: For messages before there is a logger.
        create: Makes the node.
        arguments: Command line without the program, sys.argv by default.

    Returns:
        Exit code.
    """
    received: list[int] = []
    previous = {
        number: signal.signal(number, lambda number, _: received.append(number))
        for number in (signal.SIGINT, signal.SIGTERM)
    }
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
            exported_domain()
            if changed := ensure_log_folder():
                logging.getLogger(__name__).info(changed)
            rclpy.init(args=[name, *arguments], signal_handler_options=SignalHandlerOptions.NO)
        except Exception as error:  # rclpy has no common base for what a command line can do wrong
            return _fatal(name, refusal_of_ros(error) or str(error))
        node = create()
        refuse_negative_time(node)
        warn_of_vain_overrides(node)
        _warn_of_vain_files(node, name, arguments)
        try:
            return _spun(name, node, received)
        finally:
            finish = getattr(node, "finish", None)
            if finish is not None and rclpy.ok():
                finish()
    except (ParameterError, ParameterException) as error:
        return _fatal(name, str(error))
    except ImportError as error:  # of what a parameter asks for, such as JSBSim
        if (error.name or "").startswith("uav_tracking_mpc"):
            raise
        return _fatal(name, str(error))
    except RuntimeError as error:
        if node is None and (words := refusal_of_ros(error)):
            return _fatal(name, words)
        raise
    finally:
        if node is not None:
            node.destroy_node()
        rclpy.try_shutdown()
        for number, handler in previous.items():
            # The process ends: whoever signals it once more must not break that off.
            signal.signal(number, signal.SIG_IGN if received else handler)


def _spun(name: str, node: Node, received: Sequence[int]) -> int:
    """Spin a node until a signal was received or it gives up; exit code."""
    # What exists now lives as long as the node: the collector need not look at it again, which
    # would take tens of milliseconds in the middle of a flight.
    gc.collect()
    gc.freeze()
    executor = EventsExecutor()
    executor.add_node(node)
    while rclpy.ok() and not received:
        executor.spin_once(timeout_sec=0.1)
        if words := getattr(node, "refusal", ""):
            return _fatal(name, words)
    return 0


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


def _warn_of_vain_files(node: Node, name: str, arguments: Sequence[str]) -> None:
    """Warn of parameter files that say nothing of a node, unless they are of its neighbours alone.

    Args:
        node: As it is called.
        name: Of the executable.
        arguments: Command line without the program.
    """
    others = {*SECTIONS, SCENARIO} - {name, node.get_name()}
    for flag, file in pairwise(arguments):
        if flag != "--params-file":
            continue
        try:
            sections = _sections(read_yaml(Path(file), "parameter file"))
        except ParameterError:
            continue  # ROS has read it, by a parser of its own: what it says counts
        own = node.get_fully_qualified_name()
        if any(_matches(section, own) for section in sections):
            continue
        if not sections or {section.rpartition("/")[2] for section in sections} - others:
            node.get_logger().warning(
                f"parameter file {file} has no section for {own} and no effect; it has: "
                f"{', '.join(sections) or 'none'}"
            )


def _sections(content: Any, above: str = "") -> list[str]:
    """Names of nodes in a parameter file, which may stand below their namespaces."""
    if not isinstance(content, Mapping):
        return []
    found = [above] if "ros__parameters" in content else []
    for key, inside in content.items():
        found += _sections(inside, f"{above}/{str(key).lstrip('/')}")
    return found


def _matches(section: str, name: str) -> bool:
    """Whether a section with the wildcards of ROS is of a node."""
    pattern = re.escape(section).replace(r"/\*\*", "(/[^/]+)*").replace(r"\*", "[^/]+")
    return re.fullmatch(pattern, name) is not None


def _described(create: Callable[[], Node]) -> str:
    """What a node does: the first line of its module, without its name."""
    words = sys.modules[create.__module__].__doc__ or ""
    does = words.partition("\n")[0].partition(": ")[2]
    return does[:1].upper() + does[1:]


def _fatal(name: str, message: str) -> int:
    line = " ".join(message.split())
    print(f"[FATAL] [{name}]: {line}", file=sys.stderr, flush=True)
    return 2


N = TypeVar("N", bound=Node)
TURN = 0.1  # s that a turn of the executor may wait
logger = logging.getLogger(__name__)


class BackgroundNode(Generic[N]):
    """Spins a node until it is closed.

    Args:
        create: Makes the node, with the context as keyword argument ``context``.
        domain: ROS domain; that of the environment by default.

    Attributes:
        node: The node.
    """

    def __init__(self, create: Callable[..., N], domain: int | None = None) -> None:
        if changed := ensure_log_folder():
            logger.info(changed)
        self._context = Context()
        self._context.init(args=[], domain_id=domain)
        self.node = create(context=self._context)
        self._executor = EventsExecutor(context=self._context)
        self._executor.add_node(self.node)
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._spin, name=self.node.get_name(), daemon=True)
        self._thread.start()

    def _spin(self) -> None:
        while not self._ended.is_set():
            try:
                self._executor.spin_once(timeout_sec=TURN)
            except Exception:  # what a callback raises must not end the others
                logger.exception("%s", self.node.get_name())

    def close(self) -> None:
        """End the thread, the node and its context."""
        self._ended.set()
        self._thread.join()
        self._executor.shutdown()
        self.node.destroy_node()
        self._context.try_shutdown()
