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

"""Node ``uav_simulator``: flies a plant on the commands and publishes its state."""

from __future__ import annotations

import sys
from typing import Any

from builtin_interfaces.msg import Time as TimeMessage
from rclpy.time import Time
from rclpy.timer import Timer
from std_srvs.srv import SetBool, Trigger

from uav_tracking_mpc.dynamics.orbit import FlownOrbit
from uav_tracking_mpc.estimation.measurement import Measurement
from uav_tracking_mpc.nodes.messages.conversions import set_stamp
from uav_tracking_mpc.nodes.messages.diagnostic_values import vehicle_status
from uav_tracking_mpc.nodes.messages.wires import command_segments
from uav_tracking_mpc.nodes.ros import diagnostics
from uav_tracking_mpc.nodes.ros.declared_parameters import follow_parameters
from uav_tracking_mpc.nodes.ros.endpoints import SimulatedOutage, publish, steady_timer
from uav_tracking_mpc.nodes.ros.process import run
from uav_tracking_mpc.nodes.ros.rclpy_internals import NAMELESS
from uav_tracking_mpc.nodes.topics import CLOCK
from uav_tracking_mpc.nodes.vehicle_node import VehicleNode
from uav_tracking_mpc.parameters.specification import ParameterError
from uav_tracking_mpc.settings.simulator import SimulatorParameters
from uav_tracking_mpc.simulation.plants import Plant, SimulationError, plant_named

# Who only looks comes and goes: time does not begin for them. The first has no name yet.
PASSIVE_NODES = (NAMELESS, "flight_watcher", "monitor")
LONGEST_STEP = 0.5  # s; a jump of the clock beyond this is not flown through


class UavSimulator(VehicleNode):
    """Vehicle and autopilot in simulated or real time.

    Args:
        options: As those of rclpy's Node.

    Raises:
        ParameterError: A parameter is not allowed, or there is no such plant.
    """

    def __init__(self, **options: Any) -> None:
        super().__init__("uav_simulator", SimulatorParameters, changeable=True, **options)
        follow_parameters(self, self.parameters, self._check, self._take)
        self._plant = _plant(self.parameters)
        self._truth, self._failure = self._plant.truth, ""
        self._tick = round(1e9 / self.parameters.state_rate)
        driven = self.parameters.publish_clock
        self._now = 0 if driven else self.get_clock().now().nanoseconds
        self._start = self._now
        self._started = self._paused = False
        self._reset_at, self._failsafes = 0, 0  # [ns], and counted before it
        self._clock_message = CLOCK.type()
        self._clock_publisher = publish(self, CLOCK) if driven else None
        # Whoever makes the time does not follow it: its own clock is the wall's.
        self._open(None if driven else self.parameters.state_rate, self._time if driven else None)
        self.create_service(SetBool, "~/pause", self._on_pause)
        self.create_service(Trigger, "~/reset", self._on_reset)
        self._outage = SimulatedOutage(self, "lose_state", "the state", lambda: self._now * 1e-9)
        self._timer = self._make_timer()

    def _make_timer(self) -> Timer:
        """The timer of the steps; time that this node drives runs by a steady clock."""
        period = self._tick * 1e-9
        if not self.parameters.publish_clock:
            return self.create_timer(period, self._step)
        return steady_timer(self, period / self.parameters.speed, self._step)

    def _check(self, parameters: SimulatorParameters) -> None:
        speed = self.parameters.speed
        if parameters.speed != speed and not parameters.publish_clock:
            raise ParameterError(
                f"parameter 'speed' is {parameters.speed!r}, must stay {speed!r} without "
                "publish_clock: time is the wall's"
            )
        self._plant.check(parameters)

    def _take(self, parameters: SimulatorParameters) -> None:
        before, self.parameters = self.parameters, parameters
        try:
            self._plant.change(parameters)
        except Exception as error:  # whatever a user's plant raises, the node goes on
            self._fail(error)
        if parameters.speed != before.speed:
            self.destroy_timer(self._timer)
            self._timer = self._make_timer()

    def _on_pause(self, request: Any, response: Any) -> Any:
        if self._clock_publisher is None:
            words = "time is the wall's and cannot be stopped: start with publish_clock"
            response.success, response.message = False, words
            return response
        self._paused = request.data
        words = "time stands still" if self._paused else "time runs"
        response.success, response.message = True, f"{words} at {self._now * 1e-9:.3f} s"
        if self._paused:
            self._diagnostics.announce(diagnostics.WARN, "paused: time stands still")
        else:
            self._report()
        return response

    def _on_reset(self, request: Any, response: Any) -> Any:
        """Start state, start of the plant's time; the clock goes on."""
        try:
            plant = _plant(self.parameters)
            self._truth = plant.truth
        except Exception as error:  # as of a user's plant
            response.success, response.message = False, f"not reset: {error}"
            return response
        self._failsafes += self._plant.plan.failsafes
        self._plant, self._failure = plant, ""
        self._start = self._reset_at = self._now
        words = f"the vehicle is where it started, at {self._now * 1e-9:.3f} s"
        self.get_logger().info(f"reset: {words}")
        response.success, response.message = True, words
        return response

    def _time(self) -> TimeMessage:
        return Time(nanoseconds=self._now).to_msg()

    def _on_command(self, data: bytes) -> None:
        try:
            stamp, plan, starts = command_segments(data, self._frames)
            if stamp < self._reset_at:
                raise ValueError("it answers a state from before the reset")
            self._plant.accept(plan, (stamp - self._start) * 1e-9 + starts)
            self._received += 1
        except Exception as error:  # whatever a user's plant raises, the node goes on
            self._rejected += 1
            self._refuse("command", str(error))

    def _see_orbit(self, orbit: FlownOrbit, stamp: int) -> None:
        self._plant.see_orbit(orbit)

    def _step(self) -> None:
        if not self._started:
            self._started = self._listeners() >= self.parameters.wait_for_subscribers
            if not self._started:
                self._diagnostics.report(diagnostics.WARN, "time waits for subscribers")
                return
            if self._clock_publisher is None:
                self._now = self.get_clock().now().nanoseconds  # nothing has flown yet
        if self._paused:
            return
        driven = self._clock_publisher is not None  # or followed
        self._advance(self._tick if driven else self.get_clock().now().nanoseconds - self._now)
        if self._clock_publisher is not None:
            set_stamp(self._clock_message.clock, self._now)
            self._clock_publisher.publish(self._clock_message)
        seen = None if self._failure or self._outage.lasts else self._measured()
        if seen is not None and seen.placed:  # a message without a position is none
            self._publish(self._start + round(seen.stamp * 1e9), seen)

    def _measured(self) -> Measurement | None:
        try:
            return self._plant.measured()
        except Exception as error:  # whatever a user's plant raises, the node goes on
            self._fail(error)
            return None

    def _fail(self, error: Exception) -> None:
        self._failure = f"the plant failed, its state is not published: {error}"

    def _listeners(self) -> int:
        """How many listen to the state, without who only looks."""
        known = self.get_subscriptions_info_by_topic(self._state_publisher.publisher.topic_name)
        return sum(one.node_name not in PASSIVE_NODES for one in known)

    def _advance(self, elapsed: int) -> None:
        # One integer clock: sums of floats would drift away from the stamps.
        self._plant.time = (self._now - self._start) * 1e-9
        self._now += elapsed
        if not 0 <= elapsed <= LONGEST_STEP * 1e9:
            words = f"clock moved by {elapsed * 1e-9:.3f} s, vehicle held"
            self._warnings.warn("clock", words)
            held = True
        else:
            held = self.parameters.start_on_command and not self._plant.plan.commanded
        if not held:
            self._fly(elapsed * 1e-9)
        self._plant.time = (self._now - self._start) * 1e-9
        self._report()

    def _fly(self, duration: float) -> None:
        if self._failure:
            return
        try:
            self._plant.advance(duration)
            self._truth = self._plant.truth
        except Exception as error:  # whatever a user's plant raises, the node goes on
            self._fail(error)

    def _report(self) -> None:
        if self._failure:
            self._diagnostics.report(diagnostics.ERROR, self._failure)
        elif self._outage.lasts:
            self._diagnostics.report(diagnostics.WARN, self._outage.words)
        else:
            level, words = vehicle_status(self._plant.plan)
            self._diagnostics.report(bytes([level]), words)

    def _values(self) -> dict[str, object]:
        truth = self._truth
        x, y, z = truth.position.tolist()
        east, north, up = self._plant.wind.tolist()
        return {
            "x [m]": x,
            "y [m]": y,
            "z [m]": z,
            "heading [rad]": truth.heading,
            "path angle [rad]": truth.path_angle,
            "airspeed [m/s]": truth.airspeed,
            "wind east [m/s]": east,
            "wind north [m/s]": north,
            "wind up [m/s]": up,
            "commands received": self._received,
            "commands refused": self._rejected,
            "speed": self.parameters.speed,
            "failsafe": self._failsafes + self._plant.plan.failsafes,
            **super()._values(),
        }


def _plant(parameters: SimulatorParameters) -> Plant:
    try:
        return plant_named(parameters.plant)(parameters)
    except SimulationError as error:
        raise ParameterError(f"parameter 'plant': {error}") from error


if __name__ == "__main__":
    sys.exit(run("uav_simulator", UavSimulator))
