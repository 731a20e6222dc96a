"""Node ``uav_simulator``: flies a plant on the commands and publishes its state."""

from __future__ import annotations

import sys
from typing import Any

from rclpy.clock import Clock, ClockType
from rclpy.node import Node

from uav_tracking_mpc.estimation.measurement import Measurement
from uav_tracking_mpc.nodes import diagnostics
from uav_tracking_mpc.nodes.conversions import (
    MessageError,
    nanoseconds,
    plan_from_command,
    set_air_velocity,
    set_measurement,
    set_stamp,
)
from uav_tracking_mpc.nodes.declared_parameters import declare_parameters
from uav_tracking_mpc.nodes.orbit_message import orbit_from_message
from uav_tracking_mpc.nodes.peers import Peers, Promise
from uav_tracking_mpc.nodes.run import run
from uav_tracking_mpc.nodes.topics import AIR_VELOCITY, CLOCK, COMMAND, ODOMETRY, ORBIT
from uav_tracking_mpc.parameters.specification import ParameterError
from uav_tracking_mpc.settings.simulator import SimulatorParameters
from uav_tracking_mpc.simulation.plants import Plant, SimulationError, plant_named

LONGEST_STEP = 0.5  # s; a jump of the clock beyond this is not flown through
WARNING_PERIOD = 5.0  # s


class UavSimulator(Node):
    """Vehicle and autopilot in simulated or real time.

    Args:
        options: As those of rclpy's Node.

    Raises:
        ParameterError: A parameter is not allowed, or there is no such plant.
    """

    def __init__(self, **options: Any) -> None:
        super().__init__("uav_simulator", **options)
        self.parameters = declare_parameters(self, SimulatorParameters)
        self._plant = _plant(self.parameters)
        self._truth, self._failure = self._plant.truth, ""
        self._tick = round(1e9 / self.parameters.state_rate)
        self._now = 0 if self.parameters.publish_clock else self.get_clock().now().nanoseconds
        self._start = self._now
        self._received = self._rejected = 0
        self._started = False
        self._odometry, self._air_velocity = ODOMETRY.type(), AIR_VELOCITY.type()
        self._clock_message = CLOCK.type()
        driven = self.parameters.publish_clock
        self._promise = Promise(None if driven else self.parameters.state_rate)
        self._odometry_publisher = self.create_publisher(
            ODOMETRY.type,
            ODOMETRY.name,
            self._promise.qos(ODOMETRY.qos),
            event_callbacks=self._promise.callbacks(lambda: None),
        )
        self._air_publisher = self.create_publisher(
            AIR_VELOCITY.type, AIR_VELOCITY.name, AIR_VELOCITY.qos
        )
        self._clock_publisher = None
        if self.parameters.publish_clock:
            self._clock_publisher = self.create_publisher(CLOCK.type, CLOCK.name, CLOCK.qos)
        self._peers = Peers(lambda words: self._diagnostics.report(diagnostics.WARN, words))
        self.create_subscription(
            COMMAND.type,
            COMMAND.name,
            self._on_command,
            COMMAND.qos,
            event_callbacks=self._peers.listening(COMMAND),
        )
        self.create_subscription(ORBIT.type, ORBIT.name, self._on_orbit, ORBIT.qos)
        self._diagnostics = diagnostics.Diagnostics(self, self._values)
        period = self._tick * 1e-9
        if self.parameters.publish_clock:
            steady = Clock(clock_type=ClockType.STEADY_TIME)
            self._timer = self.create_timer(
                period / self.parameters.speed, self._step, clock=steady
            )
        else:
            self._timer = self.create_timer(period, self._step)

    def _on_command(self, message: Any) -> None:
        try:
            plan, starts = plan_from_command(message)
            begin = (nanoseconds(message.header.stamp) - self._start) * 1e-9
            self._plant.accept(plan, begin + starts)
            self._received += 1
        except (MessageError, ValueError) as error:
            self._rejected += 1
            self.get_logger().warning(
                f"command refused: {error}", throttle_duration_sec=WARNING_PERIOD
            )

    def _on_orbit(self, message: Any) -> None:
        try:
            self._plant.see_orbit(orbit_from_message(message))
        except MessageError as error:
            self.get_logger().warning(
                f"orbit refused: {error}", throttle_duration_sec=WARNING_PERIOD
            )

    def _step(self) -> None:
        if not self._started:
            listeners = self._odometry_publisher.get_subscription_count()
            self._started = listeners >= self.parameters.wait_for_subscribers
            if not self._started:
                self._diagnostics.report(diagnostics.WARN, "time waits for subscribers")
                return
        self._advance(self._elapsed())
        if self._clock_publisher is not None:
            set_stamp(self._clock_message.clock, self._now)
            self._clock_publisher.publish(self._clock_message)
        if not self._failure:
            self._publish(self._plant.measured())

    def _publish(self, seen: Measurement) -> None:
        stamp = self._start + round(seen.stamp * 1e9)
        set_measurement(self._odometry, stamp, seen)
        self._odometry_publisher.publish(self._odometry)
        if seen.airspeed is not None:
            set_air_velocity(self._air_velocity, stamp, seen.airspeed)
            self._air_publisher.publish(self._air_velocity)

    def _elapsed(self) -> int:
        """Time since the last step in [ns], by the clock that this node drives or follows."""
        if self._clock_publisher is not None:
            return self._tick
        return self.get_clock().now().nanoseconds - self._now

    def _advance(self, elapsed: int) -> None:
        # One integer clock: sums of floats would drift away from the stamps.
        self._plant.time = (self._now - self._start) * 1e-9
        self._now += elapsed
        if not 0 <= elapsed <= LONGEST_STEP * 1e9:
            self.get_logger().warning(
                f"clock moved by {elapsed * 1e-9:.3f} s, vehicle held",
                throttle_duration_sec=WARNING_PERIOD,
            )
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
            self._failure = f"the plant failed, its state is not published: {error}"

    def _report(self) -> None:
        plan = self._plant.plan
        if self._failure:
            self._diagnostics.report(diagnostics.ERROR, self._failure)
        elif plan.commanded and plan.holding:
            self._diagnostics.report(
                diagnostics.WARN, "no plan left to fly: holding wings level until a command comes"
            )
        elif plan.commanded:
            self._diagnostics.report(diagnostics.OK, "flying on commands")
        else:
            self._diagnostics.report(diagnostics.WARN, "waiting for the first command")

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
            "failsafe": self._plant.plan.failsafes,
            "state deadlines missed": self._promise.broken,
            **self._peers.values(),
        }

    def finish(self) -> None:
        """Publish the last diagnostics."""
        self._diagnostics.publish()


def _plant(parameters: SimulatorParameters) -> Plant:
    try:
        return plant_named(parameters.plant)(parameters)
    except SimulationError as error:
        raise ParameterError(f"parameter 'plant': {error}") from error


def main() -> int:
    """Entry point of the executable."""
    return run("uav_simulator", UavSimulator)


if __name__ == "__main__":
    sys.exit(main())
