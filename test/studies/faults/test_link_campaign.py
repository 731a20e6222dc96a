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

"""Faults on the wire: nothing breaks, and what is broken on purpose is seen."""

import json
from itertools import islice

import pytest
from rich.console import Console

from uav_tracking_mpc.cli.main import main
from uav_tracking_mpc.links.mavlink.dialect import mavlink
from uav_tracking_mpc.settings.configuration import load_configuration
from uav_tracking_mpc.studies.faults import invariants, link_campaign
from uav_tracking_mpc.studies.faults.link_campaign import LINK_FAULTS, LinkCampaign, TakeOver
from uav_tracking_mpc.studies.faults.schedule import schedule

# The flight begins on the orbit: its way there takes time and shows nothing.
ON_ORBIT = (
    "uav_simulator.initial_position=[274.95454169735043, 0.0, 120.0]",
    "uav_simulator.initial_heading=-1.5707963267948966",
)
CROSSWIND = load_configuration("small_uav", ON_ORBIT, "crosswind")
SHORT = ("silence", "bit_flips", "take_over")  # the pilot last: the aircraft is not given back


def campaign_of(dialect="ardupilot"):
    return LinkCampaign(dialect, CROSSWIND, Console(quiet=True))


def flown(campaign, cases):
    assert not campaign.fly_cases(cases)
    return campaign.found


@pytest.mark.parametrize("dialect", ["ardupilot", pytest.param("px4", marks=pytest.mark.long)])
def test_a_short_campaign_breaks_nothing(dialect, monkeypatch):
    monkeypatch.setattr(invariants, "RECOVERY_LIMIT", 10.0)
    cases = [next(schedule({kind: LINK_FAULTS[kind]}, 3, most=1)) for kind in SHORT]
    found = flown(campaign_of(dialect), cases)
    assert [case.kinds for case in found] == [(kind,) for kind in SHORT]
    assert [case.violations for case in found] == [{}] * len(SHORT)
    assert not any(case.lost for case in found)


@pytest.mark.long
@pytest.mark.parametrize("dialect", ["ardupilot", "px4"])
def test_three_of_every_kind_break_nothing(dialect):
    cases = islice(schedule(LINK_FAULTS, 0, most=1), 3 * len(LINK_FAULTS))
    assert not any(case.violations for case in flown(campaign_of(dialect), cases))


def test_there_are_kinds_enough():
    assert len(LINK_FAULTS) >= 12


@pytest.fixture
def flight():
    return campaign_of()


def test_what_fails_is_told_and_the_next_flight_begins_anew(flight, monkeypatch):
    first = flight.link
    monkeypatch.setattr(first, "measured", lambda timeout: 1 / 0)
    flight.fly_cases(islice(schedule(LINK_FAULTS, 0, most=1), 1))
    assert flight.found[0].violations["exception"] == (1, "ZeroDivisionError: division by zero")
    assert flight.found[0].lost
    assert flight.link is not first


def set_point(bank=0.0, mask=0b11111110):
    from uav_tracking_mpc.dynamics.frames import quaternion_from_euler

    q = quaternion_from_euler(bank, 0.0, 0.0)
    return mavlink.MAVLink_set_attitude_target_message(0, 1, 1, mask, q, 0.0, 0.0, 0.0, 0.0)


def broken(flight):
    found = sorted(violation.invariant for violation in flight.violations)
    flight.violations.clear()
    return found


def test_rules_that_are_broken_are_seen(flight):
    send = flight.link.heard.connection.send
    send(set_point())
    assert broken(flight) == ["engaged"]
    flight.link.engagement.ask(flight.link.now(), "LOITER")
    send(set_point(bank=1.2))
    send(set_point(bank=float("nan")))
    command = mavlink.MAV_CMD_COMPONENT_ARM_DISARM
    send(mavlink.MAVLink_command_long_message(1, 1, command, 0, 1, 0, 0, 0, 0, 0, 0))
    send(mavlink.MAVLink_param_set_message(1, 1, b"ROLL_LIMIT_DEG", 70.0, 9))
    assert broken(flight) == ["bank", "finite", "harmless", "harmless"]
    assert broken(flight) == []


def test_a_link_that_clings_to_command_is_seen(flight):
    flight.link.takes_commands = lambda custom_mode: True
    for _ in range(200):
        flight.step()
    flight.link.engage()
    for _ in range(100):
        flight.step()
    assert flight.link.engaged
    flight.link.takes_commands = lambda custom_mode: custom_mode == 15
    flight.link.engagement.see_mode = lambda *arguments: None
    fault = TakeOver()
    fault.begin(flight, 3.0, 1)
    for _ in range(150):
        flight.step()
    fault.end(flight)
    assert "take-over" in broken(flight)


@pytest.mark.parametrize(
    ("chosen", "index"), [pytest.param((), 0, marks=pytest.mark.long), (("--case", "3"), 3)]
)
def test_the_command_writes_and_prints_what_came_of_it_and_a_seed_makes_it_the_same_again(
    tmp_path, capsys, monkeypatch, chosen, index
):
    """Also where a case comes after as many as are flown without it."""
    monkeypatch.setattr(link_campaign, "BAD_FRAMES", 1000)
    words = ["torture", "--link", "ardupilot", "--cases", "1", *chosen, "--seed", "4", "--json"]
    sets = [word for assignment in ON_ORBIT for word in ("--set", assignment)]
    assert main([*words, *sets, "--output", str(tmp_path)]) == 0
    printed = json.loads(capsys.readouterr().out)
    assert printed == json.loads((tmp_path / "torture.json").read_text(encoding="utf-8"))
    assert (tmp_path / "timeline.png").read_bytes().startswith(b"\x89PNG")
    assert (printed["dialect"], printed["faults"], printed["violations"]) == ("ardupilot", 1, 0)
    assert printed["frames"]["bad"] == 1000
    (again,) = flown(campaign_of(), islice(schedule(LINK_FAULTS, 4, most=1), index, index + 1))
    assert list(printed["per_kind"]) == list(again.kinds)
    assert printed["worst_recovery_s"] == again.recovery
