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

"""Numbers, times and plots of a flight."""

import math

import numpy as np
import pytest
from watched_flight_stand_in import sight

from uav_tracking_mpc.control.fallback import FallbackMode
from uav_tracking_mpc.settings.configuration import load_configuration
from uav_tracking_mpc.view.panel.readings import (
    RESOLUTION,
    SPAN,
    Health,
    Plots,
    Readings,
    Timing,
    in_words,
    nearest_limit,
    readings,
    worst_sensor,
)
from uav_tracking_mpc.view.watched_flight import CONTROLLER, NodeStatus, TargetSight

SMALL, PAPER = (load_configuration(name).controller for name in ("small_uav", "paper"))


def reading(name, tracking=SMALL, **more):
    (found,) = (one for one in readings(sight(**more), tracking) if one.name == name)
    return found


def test_values_and_errors_are_shown(panel):
    text = panel(Readings).show()
    for words in ("300.4 m", "+0.4", "121.0 m", "+1.0", "22.5 m/s", "+0.5", "11.5 ° left", "2.9 °"):
        assert words in text


def test_limits_are_those_of_the_controller():
    bank, climb = reading("Bank"), reading("Path angle")
    assert (bank.least, bank.most) == pytest.approx((-45.0, 45.0))
    assert (climb.least, climb.most) == pytest.approx((-9.0, 14.0))
    assert (reading("Airspeed").least, reading("Airspeed").most) == (14.0, 32.0)
    assert (reading("Range").least, reading("Altitude").least) == (60.0, 30.0)


def test_the_floor_is_told_from_the_target():
    target = TargetSight(np.array([0.0, 0.0, 25.0]))
    assert reading("Altitude", target=target).least == 5.0


def test_a_limit_as_wide_as_is_allowed_is_none():
    assert reading("Range", PAPER).least == reading("Altitude", PAPER).least == -math.inf


@pytest.mark.parametrize(
    ("degrees", "mark"),
    [(30.0, ""), (-44.0, "at limit"), (44.0, "at limit"), (46.0, "beyond limit")],
)
def test_a_value_is_marked_where_it_meets_a_limit(degrees, mark, panel, flight):
    assert reading("Bank", bank=math.radians(degrees)).mark == mark
    flight.seen = [sight(bank=math.radians(degrees))]
    text = panel(Readings).show()
    assert ("limit" in text.replace("limits", "")) == bool(mark)
    assert mark in text


def test_what_is_not_known_is_a_dash(panel, flight):
    flight.seen = [
        sight(airspeed=math.nan, bank=math.inf, latency=math.nan, target=None, errors={})
    ]
    text = panel(Readings).show()
    assert "nan" not in text and "inf" not in text
    assert text.count("–") >= 7  # noqa: RUF001
    assert cells(panel(Timing).show(), "Latency") == ["–"] * 3  # noqa: RUF001


def cells(text, row):
    """Numbers of a row of the table."""
    line = next(line for line in text.split("<tr") if f">{row}<" in line)
    return [cell.split("</td>")[0] for cell in line.split('tabular-nums">')[1:]]


def test_now_median_and_p99_of_the_last_minute(panel, flight):
    flight.seen = [sight(-100.0, solve_time=9.0)]  # longer ago than a minute
    flight.seen += [sight(0.1 * k, solve_time=1e-3 * k, latency=5e-3) for k in range(101)]
    shown = panel(Timing)
    now, median, p99 = map(float, cells(shown.show(), "Solve time"))
    assert (now, median) == pytest.approx((100.0, 50.0))
    assert p99 == pytest.approx(99.0)
    assert cells(shown.text, "Latency") == ["5.00"] * 3


def counted(time, late):
    values = {"mode feasible plan, not optimal": f"{late}", "mode optimal plan": "900"}
    return sight(time, statuses=(NodeStatus("nmpc_controller", 0, "", values),))


def test_late_plans_of_the_last_minute_are_counted(panel):
    shown = panel(Timing).shown(sight(-1.0), counted(0.0, 5), counted(10.0, 5))
    assert "Solver: no late plan in the last minute" in shown.labels()
    shown.show(counted(20.0, 6))
    assert "Solver: 1 late plan in the last minute" in shown.labels()
    shown.show(counted(50.0, 17), counted(75.0, 18))
    assert "Solver: 12 late plans in the last minute" in shown.labels()
    shown.show(counted(90.0, 2))  # of a new controller
    assert "Solver: no late plan in the last minute" in shown.labels()


def plots(shown):
    """Range error, bank, cost."""
    return [handle for handle in shown._handles() if hasattr(handle._impl.props, "series")]


def test_the_last_minutes_over_the_time_before_now(panel, flight):
    flight.seen = [sight(k * 1.0, bank=math.radians(k), cost=1.0 + k) for k in range(31)]
    error, bank, cost = plots(panel(Plots).shown())
    assert (bank.data[0][0], bank.data[0][-1]) == (-30.0, 0.0)
    assert bank.data[2] == pytest.approx(np.arange(31.0))
    assert (bank.data[3][0], bank.data[4][0]) == pytest.approx((45.0, -45.0))
    assert cost.data[2][-1] == pytest.approx(math.log10(31.0))
    assert error.data[2][-1] == 0.4


def test_plotted_points_are_bounded(panel, flight):
    shown = panel(Plots)
    for begin in range(0, 800, 10):
        flight.seen = [sight(begin + 0.1 * k) for k in range(100)]
        shown.show()
    for times, *_ in (plot.data for plot in plots(shown)):
        assert len(times) <= SPAN / RESOLUTION + 1 and times.min() >= -SPAN


def test_a_plot_without_a_point_does_not_appear(panel, flight):
    flight.seen = [sight(cost=math.nan)]
    assert [plot.visible for plot in plots(panel(Plots).shown())] == [True, True, False]


def test_what_is_not_finite_is_left_out(panel, flight):
    flight.seen = [sight(1.0), sight(2.0, cost=math.nan), sight(3.0, cost=math.inf), sight(4.0)]
    shown = plots(panel(Plots).shown())
    assert shown[2].data[0].tolist() == [-3.0, 0.0]
    assert all(np.isfinite(line).all() for plot in shown for line in plot.data)


def test_fallback_is_shaded(panel, flight):
    flight.seen = [sight(1.0), sight(2.0, mode=FallbackMode.LOITER), sight(3.0)]
    assert plots(panel(Plots).shown())[0].data[1].tolist() == [0.0, 1.0, 0.0]


def test_what_hardly_changes_is_drawn_quietly(panel, flight):
    """Else rounding would fill the plot, and each mark of its axis would read 0."""
    flight.seen = [sight(1.0 * k, errors={"range_error": 1e-13 * k}, cost=2e-5) for k in range(9)]
    error, _, cost = plots(panel(Plots).shown())
    for plot in (error, cost):
        assert np.ptp(plot.data[2]) < 1e-9
        assert np.ptp(np.concatenate(plot.data[2:])) == pytest.approx(1.0)


def test_time_is_no_date(panel):
    assert all(plot.scales["x"]["time"] is False for plot in plots(panel(Plots)))


TRACKING = load_configuration("small_uav").controller


def off(error):
    return sight(errors={"range_error": error})


@pytest.mark.parametrize(
    ("seen", "words"),
    [
        (off(0.4), "well: it is on the orbit"),
        (off(-312.3), "on its way to the orbit: 312 m to go"),
        (
            sight(errors={"range_error": 3.0, "altitude_error": -26.6}),
            "on its way to the orbit: 27 m to go",
        ),
        (sight(errors={}), "flies the best plan"),
        (sight(mode=None), "waits for its first command"),
        (
            sight(mode=FallbackMode.FEASIBLE, reason="time limit 0.05 s reached, gradient 0.862"),
            "flies plans that are safe, but cut short for time",
        ),
        (
            sight(mode=FallbackMode.LOITER, reason="target position is lost"),
            "circles by the loiter law, without a plan: target position is lost",
        ),
    ],
)
def test_one_line_says_how_it_is(seen, words):
    assert in_words(seen, TRACKING) == words


@pytest.mark.parametrize(
    ("more", "words", "used"),
    [
        ({"bank": math.radians(-40.0)}, "bank, 5.0 ° away", 40.0 / 45.0),
        ({"airspeed": 14.0}, "airspeed, 0.0 m/s away", 1.0),
        ({"position": np.array([275.0, 0.0, 31.0])}, "altitude, 1.0 m away", 30.0 / 31.0),
    ],
)
def test_the_nearest_limit_is_that_of_which_most_is_used(more, words, used):
    margin = nearest_limit(sight(**more), TRACKING)
    assert margin.words == words
    assert margin.used == pytest.approx(used)


def test_what_is_beyond_a_limit_that_has_no_other_side_is_told():
    floor = load_configuration("small_uav", ["nmpc_controller.height_min=50"]).controller
    low = sight(
        position=np.array([300.0, 0.0, 40.0]), target=TargetSight(np.array([0.0, 0.0, 100.0]))
    )
    assert nearest_limit(low, floor) == ("altitude, 10.0 m beyond", 1.0)
    above = load_configuration("small_uav", ["nmpc_controller.airspeed_min=0"]).controller
    margin = nearest_limit(sight(airspeed=33.0), above)
    assert margin.words == "airspeed, 1.0 m/s beyond"
    assert margin.used > 1.0


def test_a_fence_is_a_limit():
    fenced = load_configuration("small_uav", ["nmpc_controller.fence_radius=400.0"]).controller
    for east, words in ((390.0, "fence, 10 m away"), (420.0, "fence, 20 m beyond")):
        assert nearest_limit(sight(position=np.array([east, 0.0, 121.0])), fenced).words == words
    assert nearest_limit(sight(), None) is None


def sensors(**states):
    values = {f"{name} sensor": state for name, state in states.items()}
    target = TargetSight(np.zeros(3), std=2.0, measured=np.zeros(3))
    return sight(target=target, statuses=(NodeStatus(CONTROLLER, 0, "", values),))


def test_a_sensor_that_is_left_out_is_the_worst():
    margin = worst_sensor(sensors(airspeed="stuck", heading="used"), TRACKING)
    assert margin == ("airspeed: stuck, left out", 1.0)


def test_else_it_is_told_how_surely_the_target_is_known():
    margin = worst_sensor(sensors(airspeed="used", heading="used"), TRACKING)
    assert margin.words == "target, known to ±6.0 m"
    assert margin.used == pytest.approx(6.0 / 30.0)
    assert worst_sensor(sight(target=None), TRACKING).words == "target: not seen yet"
    assert worst_sensor(sight(), TRACKING) is None


def test_words_of_others_are_no_html(panel, flight):
    flight.seen = [sight(mode=FallbackMode.HOLD, reason="<img src=x>")]
    assert "<img" not in panel(Health).show()
