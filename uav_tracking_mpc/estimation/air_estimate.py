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

"""Aircraft and air as they are known: what is measured, less what sensors get wrong.

Three filters of the wind run side by side. One knows all sensors, and is what is flown by. One owes
nothing to the airspeed, one nothing to the heading: each judges the sensor that it does not know,
and tells what stands in for it. Where a sensor is found wrong, the first goes on from the one that
nothing wrong has come into. A step of all of it is one compiled function; only where a flight
begins and where a sensor is left out its memory is written otherwise.
"""

from __future__ import annotations

import functools
import math
from types import SimpleNamespace

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.dynamics import vehicle as vehicle_model
from uav_tracking_mpc.dynamics.air import gust_scales
from uav_tracking_mpc.estimation import (
    air_check,
    motion_check,
    noise_meter,
    rate_aided,
    wind_filter,
)
from uav_tracking_mpc.estimation.flight_path import LEAST_AIRSPEED, NOSE_JUMP
from uav_tracking_mpc.estimation.measurement import Measurement
from uav_tracking_mpc.estimation.sensor_health import (
    CODE,
    HEADING,
    JUMPED,
    OFF,
    SENSORS,
    SILENT,
    STATES,
    STUCK,
    USED,
    SensorHealth,
)
from uav_tracking_mpc.estimation.wind_filter import (
    ALPHA,
    BETA,
    DIAGONAL,
    LANE,
    STATE,
    B,
    G,
    P,
    T,
    W,
)
from uav_tracking_mpc.symbolic.layout import Layout
from uav_tracking_mpc.symbolic.native_code import NativeFunction

LEAST_LEVEL = 0.1  # -, share of the airspeed, below which the wind tells nothing of it
# m/s, standard deviations of what is not measured. Along the way enough that in hours nothing is
# known of the wind there; of a heading no more than what a linearised turn bears.
BLIND, WITHOUT_AIRSPEED = 100.0, 1e4
TURN_SLIP = 0.15  # -, by which an aircraft that slips may turn quicker than its bank tells
MAIN, NO_AIRSPEED = range(2)  # filters: what they go by
LANES = ("main", "no_airspeed", "no_heading")
# Of their covariance
LEVEL_WIND, LEVEL_GUST = (DIAGONAL[each.start : each.stop - 1].tolist() for each in (W, G))
OF_POSITION = DIAGONAL[P].tolist()  # its variances, in a triangle

SEEN = Layout(
    elapsed=1, position=3, placed=1, ground=3, heading=1, path_angle=1, airspeed=1, measured=1,
    rates=3, biased=3, compass=1, turn_told=1, stuck=2,
    noise=3, position_noise=3, velocity_noise=3, scales=3, by_turn=1,
)  # fmt: skip
MEMORY = Layout(
    **dict.fromkeys(LANES, LANE),
    meters=wind_filter.METERS.layout,
    places=wind_filter.PLACES.layout,
    quick=wind_filter.QUICK,
    aided=rate_aided.RATE_AIDED,
    air=air_check.AIR_CHECK,
    compass=air_check.COMPASS_CHECK,
    follower=wind_filter.FOLLOWER,
    velocity=motion_check.VELOCITY_CHECK,
    place=motion_check.POSITION_CHECK,
    ground=3,
)
# (x, y, z, psi, chi, v) through the air; (psi', chi', v'); mean wind [m/s] and how it changes
# [m/s^2], the gust that lasts [m/s] and how long gusts last on each axis [s], intensity of level
# gusts [m^2/s^3]. State of each sensor, whether the heading has jumped, and the air changed; the
# mean wind without the airspeed [m/s], whether it is known, the standard deviation of what ground
# velocity and wind tell of the airspeed [m/s]; by how much an airspeed that is still used may be
# too high, and too low [m/s]; the standard deviation of positions [m], and by how much one that is
# carried on may err [m].
FOUND = Layout(
    vehicle=6, rates=3, wind=3, trend=3, gust=3, times=3, walk=1,
    states=4, snapped=1, changed=1, without=3, known=1, deviation=1, doubts=2,
    position_noise=1, astray=1,
)  # fmt: skip


class AirEstimate:
    """Measurements in, aircraft and air out.

    Attributes:
        health: Of all sensors.
        found: Aircraft and air as they are known, by :data:`FOUND`; overwritten by each update.
        state: Of the filter that is flown by, by :data:`STATE`; likewise.
    """

    def __init__(self) -> None:
        self._memory, self._told = np.zeros(MEMORY.size), np.zeros(SEEN.size)
        self._known, self._seen = MEMORY.parts(self._memory), SEEN.parts(self._told)
        self.state = STATE.parts(self._known.main.state)
        self._step = NativeFunction(_step(), [self._memory, self._told])
        self.found = FOUND.parts(self._step.results[1])
        self.reset()

    def reset(self) -> None:
        """Forget the air and believe every sensor."""
        self._memory[:], self._step.results[1][:] = MEMORY.begin, 0.0
        self._time: float | None = None
        self.health = SensorHealth()

    def trust_compass(self) -> None:
        """Take it as it is: an autopilot that finds its heading after take-off makes it jump."""
        compass = self._known.compass
        compass.snapped[:] = compass.astray[:] = compass.drifted[:] = 0.0

    def _forget(self, *names: str) -> None:
        for name in names:
            MEMORY.part(name, self._memory)[:] = MEMORY.part(name, MEMORY.begin)

    def update(
        self,
        measurement: Measurement,
        vehicle: NDArray[np.float64],
        rates: NDArray[np.float64],
        ground: float,
        missing: bool,
        nose: tuple[float, float] | None = None,
        stuck: tuple[bool, bool] = (False, False),
        by_turn: float = math.inf,
    ) -> SimpleNamespace:
        """Take in a measurement.

        Args:
            measurement: Of the path through the air.
            vehicle: (x, y, z, psi, chi, v) of it, shape (6,).
            rates: psi' and chi' as measured in [rad/s], v' as commanded in [m/s^2], shape (3,).
            ground: Height of the ground in ``map`` in [m], for the length of the gusts.
            missing: Whether there is no airspeed.
            nose: Where it points by the compass in [rad] and how it turns by the gyros in [rad/s],
                where psi and psi' are not by them.
            stuck: Whether the heading is stuck, and whether the ground velocity is.
            by_turn: Airspeed that bank and turn tell in [m/s]; inf where they tell none.

        Returns:
            Aircraft and air as they are known, by :data:`FOUND`; overwritten by the next update.

        Raises:
            ValueError: There has been no position since the flight began.
        """
        noise, placed = measurement.noise, measurement.placed
        position = (vehicle[:3] if placed else self._known.main.state[P]).tolist()
        heading, path_angle = (
            (measurement.heading, measurement.path_angle) if missing else vehicle[3:5].tolist()
        )
        scales = gust_scales(position[2] - ground, 0.0)
        elapsed = -1.0 if self._time is None else measurement.stamp - self._time
        begins = not 0.0 <= elapsed <= noise_meter.LONGEST_GAP
        if begins and not placed:
            raise ValueError("no position is known")
        # In the order of SEEN: to write a part by its name takes five times as long.
        self._told[:] = [
            0.0 if begins else elapsed, *position, placed, *measurement.ground_velocity.tolist(),
            heading, path_angle, vehicle[5], not missing, *rates.tolist(),
            nose is None, nose is None, True,
            *(nose or (measurement.heading, measurement.turn_rate)), *stuck,
            noise.heading, noise.path_angle, noise.airspeed, *noise.position, *noise.velocity,
            scales.long, scales.long, scales.short, by_turn,
        ]  # fmt: skip
        if begins:
            self._begin()
        self._time = measurement.stamp
        before = self.found.states.tolist()
        self._step.evaluate()
        self._memory[:], states = self._step.results[0], self.found.states.tolist()
        # A filter goes on from the one that no wrong sensor has come into. Before the wind is known
        # without the airspeed, what one has told until it leapt or fell silent is worth more.
        compared = self._known.air.weight[air_check.AIRSPEED] > 0.0
        for state, earlier, lane in zip(states, before, LANES[1:], strict=False):
            if state != earlier and state != CODE[USED]:
                main, other = (MEMORY.part(name, self._memory) for name in ("main", lane))
                told_before = lane == LANES[NO_AIRSPEED] and state in (CODE[SILENT], CODE[JUMPED])
                if told_before and not compared:
                    other[:] = main
                elif state > CODE[SILENT]:
                    main[:] = other
        for sensor, state in zip(SENSORS, states, strict=True):
            self.health.states[sensor] = STATES[int(state)]
        if self.found.snapped[0]:
            self.health.states[HEADING] = JUMPED
        if self.found.changed[0]:  # the air: nothing is known of the wind
            self._forget(*LANES, "meters", "places", "quick")
            self.found.without[:] = self.found.known[:] = 0.0
            self._time = None
        return self.found

    def _begin(self) -> None:
        """Let position and motion begin anew, whatever was known of them."""
        seen, known = self._seen, self._known
        motion = np.concatenate([seen.heading, seen.path_angle, seen.airspeed])
        heading, path_angle, airspeed = motion.tolist()
        for name in LANES:
            lane = getattr(known, name)
            wind_filter.begin_position(lane, seen.position, seen.position_noise)
            lane.air[:] = vehicle_model.air_velocity(heading, path_angle, airspeed, np)
        rate_aided.begin_values(known.aided, motion, seen.rates, seen.noise)
        self._forget("velocity", "place", "compass")
        known.velocity.begin[:] = known.follower.place[:] = seen.position
        known.velocity.before[:] = known.follower.velocity[:] = known.ground[:] = seen.ground


@functools.cache
def _step() -> ca.Function:
    """Memory and what is seen to memory and what is found."""
    memory, known = MEMORY.symbol("memory")
    measured, seen = SEEN.symbol("seen")
    dt = seen.elapsed
    lanes = [getattr(known, lane) for lane in LANES]
    main, meters, place, sensors = lanes[MAIN], known.meters, known.place, known.air
    places = known.places

    # Ground velocity, compared with what is expected before airspeed and heading are
    state = main.state
    variance = ca.sum1(main.triangle[DIAGONAL[W.start : B.stop].tolist()])
    deviation = ca.sqrt(ca.fmax(variance + ca.mmax(seen.velocity_noise) ** 2, 0.0))
    expected = main.air + state[W] + state[G] + state[B]
    position_noise = ca.fmax(ca.sqrt(places.held), ca.mmax(seen.position_noise))
    fresh = motion_check.is_fresh(place, seen.position, seen.placed)
    told = fresh * ca.logic_not(motion_check.is_far(place))
    velocity, odd, contrary, changed = motion_check.velocity_checked(
        known.velocity, dt, seen.position, told, seen.ground, expected, deviation, position_noise
    )
    contrary = ca.logic_or(contrary, seen.stuck[1])
    odd, changed = ca.logic_or(odd, contrary), ca.logic_and(changed, ca.logic_not(contrary))
    no_airspeed_used = ca.logic_or(
        ca.logic_not(seen.measured), sensors.reasons[air_check.AIRSPEED] > 0.0
    )
    turning = seen.rates[0] * ca.vertcat(-main.air[1], main.air[0], 0.0)
    follower, by_positions = wind_filter.followed(known.follower, dt, seen.position, told, turning)
    # Without an airspeed the expected velocity would confirm itself: positions replace it.
    instead = ca.if_else(no_airspeed_used, by_positions, expected)
    used_ground = ca.if_else(odd, instead, seen.ground)

    # Airspeed and heading
    turn_told = ca.logic_not(seen.turn_told == 0.0)
    level_variances = ca.vertcat(*[ca.mmax(lane.triangle[LEVEL_WIND]) for lane in lanes[1:]])
    wind_deviations = ca.sqrt(ca.fmax(level_variances, 0.0))
    # A compass that leaps on the ground is aligned; one that is left out may be right again.
    gyros_judge = ca.logic_and(turn_told, ca.norm_2(seen.ground[:2]) > LEAST_AIRSPEED)
    nobody_else = ca.logic_or(no_airspeed_used, sensors.weight[air_check.HEADING] == 0.0)
    left_out = sensors.reasons[air_check.HEADING] > 0.0
    nose_used = ca.logic_not(ca.logic_or(seen.biased[0], left_out))
    compass, strayed, snapped = air_check.compass_checked(
        known.compass,
        dt,
        seen.compass,
        seen.turn_told,
        ca.logic_and(gyros_judge, nobody_else),
        ca.logic_and(gyros_judge, nose_used),
        seen.stuck[0],
        ca.fmax(ca.sqrt(known.aided.meters.held[0]), seen.noise[0]),
    )
    heading = seen.heading - snapped
    level = ca.fmax(ca.cos(seen.path_angle), LEAST_LEVEL)
    u = [(used_ground - lane.state[B] - lane.state[W])[:2] for lane in lanes[1:]]
    blind = lanes[NO_AIRSPEED].state
    winds = [ca.norm_2((lane.state[W] + lane.state[G])[:2]) for lane in lanes]
    air, out, turned, along = air_check.air_checked(
        sensors,
        dt,
        heading,
        seen.airspeed,
        seen.measured,
        ca.fmax(level * (1.0 - state[ALPHA]), LEAST_LEVEL),
        (u[0], u[1]),
        ca.if_else(odd, BLIND, wind_deviations),  # what stands in for a velocity judges nobody
        meters.weight >= noise_meter.MEMORY,
        ca.vertcat((blind[W] + blind[G])[:2], blind[BETA] * seen.airspeed),
        winds[2] < winds[MAIN],
        turn_told,
        strayed,
        compass.astray,
        seen.rates[2],
        seen.stuck[0],
        ca.fmax(ca.sqrt(known.aided.meters.held[2]), seen.noise[2]),
    )
    by_wind = turned, along / level
    heading = ca.if_else(out[1], by_wind[0], heading)
    # What is smoothed goes over to what stands in at once: it would blame the others.
    goes_over = ca.logic_and(out[1], ca.logic_not(left_out))
    known.aided.value[0] += goes_over * ca.remainder(heading - known.aided.value[0], math.tau)
    meter, least = known.aided.meters, rate_aided.METERS.layout
    for name in ("short", "long", "held"):  # it has noise of its own
        begin = least.part(name, least.begin)[0]
        getattr(meter, name)[0] = ca.if_else(goes_over, begin, getattr(meter, name)[0])
    airspeed = ca.if_else(out[0], by_wind[1], seen.airspeed)
    motion = ca.vertcat(heading, seen.path_angle, airspeed)
    aided = rate_aided.smoothed(known.aided, dt, motion, seen.rates, seen.noise, seen.biased)
    heading, path_angle, airspeed = ca.vertsplit(aided.value)

    # Position
    carried = state[P] + dt * (0.5 * (known.ground + used_ground) - state[B])
    scatter = wind_filter.PLACES.scatter(places, seen.position - carried)
    scatter *= fresh * (ca.mmax(seen.position_noise) == 0.0)
    deviation = ca.sqrt(ca.fmax(position_noise**2, scatter))
    placed, code, position, seen_axes, moved, scattered = motion_check.position_checked(
        place, dt, seen.position, seen.placed, carried, used_ground[2], deviation, odd
    )
    # The first positions have been believed too much where they turn out to be noisy; and noise is
    # metered of how those that wait change, too, or it would never be found.
    believed = ca.fmax(places.held, wind_filter.POSITION_NOISE**2)
    uncertain = ca.if_else(scatter > believed, scatter, 0.0)
    for lane in lanes:
        lane.triangle[OF_POSITION] = ca.fmax(lane.triangle[OF_POSITION], uncertain)
    jumps = seen.position - carried - place.off
    read = position + fresh * (code == CODE[JUMPED]) * (place.jumped > 0.0) * jumps
    # Once positions scatter, what was metered before counts as little as some seconds of samples.
    places.weight = ca.fmin(places.weight, ca.if_else(scattered, noise_meter.EARLY, ca.inf))

    # A turn that is quicker than its bank: the airspeed reads too much, or the aircraft slips. That
    # is known before the wind is, which then tells which of them, so alpha becomes uncertain.
    excess = (1.0 - TURN_SLIP) * airspeed * (1.0 - state[ALPHA]) - seen.by_turn
    compared = air.weight[air_check.AIRSPEED] >= noise_meter.MEMORY
    unused = ca.logic_or(no_airspeed_used, ca.logic_or(out[0], compared))
    excess = ca.if_else(unused, 0.0, ca.fmax(excess, 0.0))
    unexplained = ca.fmax(air.unexplained, excess)

    # The filters of the wind. What is known of it in one direction tells no heading yet: a filter
    # that went by one would drift to and fro along a circle of winds, all of the same airspeed.
    turned = ca.if_else(wind_deviations[1] > air_check.WIND_IN_GUSTS, heading, turned)
    walks = wind_filter.METERS.walks(meters)
    # Heading and airspeed that each goes by, and which of airspeed and heading it does not know
    guesses = (
        (heading, airspeed, out[0], out[1]),
        (heading, by_wind[1], ca.SX(1.0), out[1]),
        (turned, airspeed, out[0], ca.SX(1.0)),
    )
    ahead = []
    for lane, (psi, v, no_airspeed, no_heading) in zip(lanes, guesses, strict=True):
        lane.state[P] = ca.if_else(moved, state[P] + position - carried, lane.state[P])
        velocity_through = ca.vertcat(*vehicle_model.air_velocity(psi, path_angle, v, ca))
        loose = _loose(heading, no_airspeed, no_heading)
        ahead.append(
            wind_filter.predicted(
                lane, dt, velocity_through, seen.scales, loose, walks, unexplained
            )
        )
    through, state = wind_filter.through_air(ahead[MAIN]), ahead[MAIN].state
    expected = through + state[W] + state[G] + state[B]
    ground = ca.if_else(odd, ca.if_else(no_airspeed_used, by_positions, expected), seen.ground)
    told, told_velocity = seen.position_noise**2, seen.velocity_noise**2
    told_mean = ca.sum1(told) / 3.0
    by_source = ca.vertcat(0.5 * ca.sum1(told_velocity[:2]), told_velocity[2])
    metered = wind_filter.METERS.metered(meters, dt, ground - through, by_source)
    metered_places = wind_filter.PLACES.metered(places, dt, read - state[P], told_mean)
    share = ca.if_else(told_mean > 0.0, told / told_mean, 1.0)
    noise = ca.vertcat(
        ca.fmax(metered_places.held * share, ca.fmax(scatter, wind_filter.POSITION_NOISE**2)),
        *[ca.fmax(metered.held[k], wind_filter.VELOCITY_NOISE**2) for k in (0, 0, 1)],
    )
    noise[3:] += odd * ca.if_else(no_airspeed_used, wind_filter.FOLLOWED_DEVIATION, BLIND) ** 2
    # What is carried on tells nothing, nor does a velocity that comes again with its position.
    noise[:3] += BLIND**2 * (dt > 0.0) * (1.0 - seen_axes)
    again = ca.sumsqr((seen.ground - known.velocity.before)[:2]) == 0.0
    noise[3:5] += BLIND**2 * (dt > 0.0) * again * ca.logic_not(fresh)
    read = ca.vertcat(position, ground)
    after = [wind_filter.corrected(lane, read, noise) for lane in ahead]

    main, blind = after[MAIN], after[NO_AIRSPEED]
    state = main.state
    unknown = ca.mmax(blind.triangle[LEVEL_WIND]) + ca.mmax(blind.triangle[LEVEL_GUST])
    quick, gust = wind_filter.lasting_gust(known.quick, dt, state[G], ahead[MAIN])
    remembered = SimpleNamespace(
        **dict(zip(LANES, after, strict=True)),
        meters=metered,
        places=metered_places,
        quick=quick,
        aided=aided,
        air=air,
        compass=compass,
        follower=follower,
        velocity=velocity,
        place=placed,
        ground=used_ground,
    )
    found = SimpleNamespace(
        vehicle=ca.vertcat(
            state[P] + placed.faded,
            ca.remainder(heading - state[BETA], math.tau),
            path_angle,
            airspeed * (1.0 - state[ALPHA]),
        ),
        rates=ca.vertcat(seen.rates[:2] - (seen.biased * aided.bias)[:2], seen.rates[2]),
        wind=state[W],
        trend=ca.vertcat(state[T], 0.0),
        gust=gust,
        times=ahead[MAIN].times,
        states=ca.vertcat(
            air.reasons, code, odd * ca.if_else(seen.stuck[1], CODE[STUCK], CODE[OFF])
        ),
        snapped=ca.fabs(snapped) > motion_check.RETURN * NOSE_JUMP,
        changed=changed,
        without=blind.state[W],
        known=ca.mmax(blind.triangle[LEVEL_WIND]) <= air_check.WIND_KNOWN**2,
        deviation=ca.sqrt(ca.fmax(unknown, 0.0)),
        walk=walks[0],
        doubts=air.doubts,
        position_noise=ca.sqrt(ca.fmax(metered_places.held, 0.0)),
        astray=placed.astray,
    )
    return ca.Function(
        "air_estimate", [memory, measured], [MEMORY.joined(remembered), FOUND.joined(found)]
    )


def _loose(heading: ca.SX, airspeed: ca.SX, across: ca.SX) -> ca.SX:
    """Directions in which the air velocity is not measured, times the deviation, shape (3, 2).

    Args:
        heading: That is gone by in [rad].
        airspeed: Whether the airspeed is not.
        across: Whether the heading is not.
    """
    east, north = ca.cos(heading), ca.sin(heading)
    along, across = WITHOUT_AIRSPEED * airspeed, BLIND * across
    return ca.vertcat(
        ca.horzcat(along * east, -across * north),
        ca.horzcat(along * north, across * east),
        ca.SX.zeros(1, 2),
    )
