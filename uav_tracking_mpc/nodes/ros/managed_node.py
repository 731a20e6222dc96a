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

"""A managed node: every transition is logged and shown, and none that is refused ends the node."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable
from enum import Enum
from functools import partialmethod
from typing import Any

from rclpy.lifecycle import LifecycleNode, LifecycleState, TransitionCallbackReturn
from std_srvs.srv import SetBool

from uav_tracking_mpc.nodes.ros.rclpy_internals import wrap_transitions

SUCCESS, FAILURE = TransitionCallbackReturn.SUCCESS, TransitionCallbackReturn.FAILURE
ERROR = TransitionCallbackReturn.ERROR
DISENGAGED = "disengaged by the service engage"


class Stage(Enum):
    """Primary state of a managed node; the value is what ROS and people call it."""

    UNCONFIGURED = "unconfigured"
    INACTIVE = "inactive"
    ACTIVE = "active"
    FINALIZED = "finalized"


class TransitionError(Exception):
    """A transition is refused, in words; the node stays as it was."""


class ManagedNode(LifecycleNode):
    """A managed node, of which four methods say what its transitions do.

    A finalized node lives on until its process ends, as managed nodes do, and goes on saying that
    it was shut down.

    Args:
        name: Of the node.
        options: Those of rclpy's Node.

    Attributes:
        stage: Where it is in its life.
        trouble: Why the latest transition failed, in words; empty if it did not.
    """

    def __init__(self, name: str, **options: Any) -> None:
        super().__init__(name, **options)
        self.stage, self.trouble = Stage.UNCONFIGURED, ""
        wrap_transitions(self, self._surviving)

    def _surviving(self, change: Callable[..., Any]) -> Callable[..., Any]:
        def asked(request: Any, response: Any) -> Any:
            try:
                return change(request, response)
            except RuntimeError:  # how rclpy tells that there is no such transition from here
                wanted = request.transition.label or f"number {request.transition.id}"
                self.get_logger().warning(
                    f"transition {wanted} refused: there is none from {self.stage.value}"
                )
                response.success = False
                return response

        return asked

    @abstractmethod
    def configure(self) -> None:
        """Make ready.

        Raises:
            TransitionError: That is not possible.
        """

    @abstractmethod
    def activate(self) -> None:
        """Work from now on."""

    @abstractmethod
    def deactivate(self) -> None:
        """Rest from now on, ready."""

    @abstractmethod
    def release(self) -> None:
        """Forget everything; may be called at any stage, and twice."""

    @abstractmethod
    def show(self, trouble: str) -> None:
        """Say at which stage the node is.

        Args:
            trouble: What went wrong, in words; empty if nothing did.
        """

    def _go(
        self, work: str, stage: Stage, done: str, _: LifecycleState
    ) -> TransitionCallbackReturn:
        self.trouble = ""
        try:
            getattr(self, work)()
        except TransitionError as error:
            self.trouble = str(error)
            self._tell(f"cannot be {done}: {error}")
            return FAILURE
        except Exception as error:  # rclpy would swallow it without a word
            self.trouble = f"cannot be {done}: {type(error).__name__}: {error}"
            return ERROR
        self.stage = stage
        self.get_logger().info(f"{done}: {stage.value}")
        self.show("")
        return SUCCESS

    # As rclpy calls them: the method that does it, the stage it leads to, and what is done then.
    on_configure = partialmethod(_go, "configure", Stage.INACTIVE, "configured")
    on_activate = partialmethod(_go, "activate", Stage.ACTIVE, "activated")
    on_deactivate = partialmethod(_go, "deactivate", Stage.INACTIVE, "deactivated")
    on_cleanup = partialmethod(_go, "release", Stage.UNCONFIGURED, "cleaned up")
    on_shutdown = partialmethod(_go, "release", Stage.FINALIZED, "shut down")

    def on_error(self, state: LifecycleState) -> TransitionCallbackReturn:
        """What a transition could not do leads back to unconfigured; see rclpy.

        Args:
            state: Before the transition.
        """
        trouble = self.trouble
        answer = self._go("release", Stage.UNCONFIGURED, "released", state)
        if answer is not SUCCESS:
            self.stage = Stage.FINALIZED
            self._tell(self.trouble)
            return FAILURE
        self.trouble = trouble
        self._tell(trouble)
        return SUCCESS

    def _tell(self, trouble: str) -> None:
        self.get_logger().error(f"{trouble}; now {self.stage.value}")
        self.show(trouble)


class CommandGate:
    """Takes the commands away from an active controller and gives them back.

    It is engaged at the start, and stays as it was told to be through deactivation and cleanup:
    what a pilot has stopped, a lifecycle manager does not start. Whether an autopilot *flies* what
    is sent is another matter, which its link decides (``autopilot_link/engage``).

    Args:
        node: The controller's.
        told: Called when an active node is to send commands from now on, or none any more.

    Attributes:
        engaged: Whether commands are to be sent.
    """

    def __init__(self, node: ManagedNode, told: Callable[[], None]) -> None:
        self.engaged = True
        self._node, self._told = node, told
        node.create_service(SetBool, "~/engage", self._on_request)

    def _on_request(self, request: Any, response: Any) -> Any:
        response.success, response.message = self._answer(request.data)
        self._node.get_logger().info(f"engage {str(request.data).lower()}: {response.message}")
        return response

    def _answer(self, wanted: bool) -> tuple[bool, str]:
        active = self._node.stage is Stage.ACTIVE
        if wanted and not active:
            return False, "not engaged: the node is not active, activate it first"
        self.engaged = wanted
        if active:
            self._told()
        if wanted:
            return True, "engaged: states are answered with commands"
        return True, "disengaged: the vehicle flies its plan to the end, then holds"
