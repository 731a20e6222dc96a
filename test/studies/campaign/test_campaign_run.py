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


import os
import signal
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from itertools import islice

import pytest
from campaign_files import SHORT, short_campaign

from uav_tracking_mpc.parameters.specification import ParameterError
from uav_tracking_mpc.settings.configuration import load_configuration
from uav_tracking_mpc.simulation import closed_loop
from uav_tracking_mpc.studies.campaign import campaign_run
from uav_tracking_mpc.studies.campaign.campaign_run import (
    fly_batch,
    fly_one,
    planned,
    run_campaign,
    shared_formulation,
)
from uav_tracking_mpc.studies.executors import DaskExecutor, LocalExecutor, WorkerError

TRUTH = {
    "told.response": 1.0,
    "uav_simulator.velocity_noise": 0.0,
    "target_publisher.motion": "stationary",
}


def plans(campaign):
    return [planned(campaign, number) for number in range(campaign.total)]


def test_groups_follow_one_another_and_errors_take_turns(tmp_path):
    """One error at a time leaves all else right."""
    flights = plans(short_campaign(tmp_path))
    assert [flight.group for flight in flights] == ["single"] * 3 + ["together"] * 3
    assert [flight.error for flight in flights[:3]] == ["lag", "sensors", "driving"]
    assert {flight.error for flight in flights[3:]} == {"lag+sensors+driving"}
    for flight, wrong in zip(flights, TRUTH, strict=False):
        others = {key: value for key, value in TRUTH.items() if key != wrong}
        assert {key: flight.values[key] for key in others} == others


def test_a_share_of_the_range_keeps_within_it(tmp_path):
    flights = plans(short_campaign(tmp_path, flights=60))[30:]
    told = [flight.values["told.response"] for flight in flights]
    assert 0.5 <= min(told) < max(told) <= 2.0
    assert max(flight.values["uav_simulator.velocity_noise"] for flight in flights) <= 0.15
    motions = {flight.values["target_publisher.motion"] for flight in flights}
    assert motions == {"stationary", "circle", "line"}


def test_values_are_what_is_flown(tmp_path):
    flight = plans(short_campaign(tmp_path))[0]
    configuration = flight.configuration("l1")
    told = [flight.values["told.response"] * lag for lag in configuration.simulator.rate_lag]
    assert list(configuration.controller.rate_lag) == told
    assert configuration.controller.law == "l1"
    assert configuration.mission.duration == 6.0


def test_a_key_is_drawn_from_a_stream_of_its_own(tmp_path):
    """More flights, more keys or other laws leave what a flight meets as it was."""
    before = planned(short_campaign(tmp_path), 2)
    draw = {"uav_simulator.initial_speed": {"uniform": [20.0, 24.0]}, **SHORT["draw"]}
    after = planned(short_campaign(tmp_path, draw=draw, laws=["vector_field"]), 2)
    assert {key: after.values[key] for key in before.values} == before.values
    assert after.sections["uav_simulator"]["seed"] == before.sections["uav_simulator"]["seed"]


def test_seeds_differ(tmp_path):
    flights = plans(short_campaign(tmp_path))
    seeds = {flight.sections["uav_simulator"]["seed"] for flight in flights}
    seeds |= {flight.sections["target_publisher"]["seed"] for flight in flights}
    assert len(seeds) == 12
    assert planned(short_campaign(tmp_path, seed=4), 0).values != flights[0].values


def test_a_sweep_flies_all_combinations_of_the_same_draws(tmp_path):
    draw = {
        **SHORT["draw"],
        "nmpc_controller.range": {"grid": [250.0, 350.0, 3]},
        "target_publisher.rate": {"values": [5.0, 10.0]},
    }
    campaign = short_campaign(tmp_path, draw=draw, flights=2, errors=None, groups=None)
    flights = plans(campaign)
    assert len(flights) == 12
    points = [
        (flight.values["nmpc_controller.range"], flight.values["target_publisher.rate"])
        for flight in flights
    ]
    assert len(set(points)) == 6
    assert points[0] == points[1]
    assert len({flight.values["wind.speed"] for flight in flights}) == 2


TASKS = [(number, "nmpc") for number in (0, 1, 4)]


@pytest.fixture(scope="module")
def campaign(tmp_path_factory):
    draw = {
        "mission.duration": 4.0,
        "start.distance": {"uniform": [290.0, 320.0]},
        "nmpc_controller.range": {"uniform": [250.0, 350.0]},
        "nmpc_controller.offset_weights[0]": {"uniform": [3.0, 5.0]},
        "wind.speed": {"uniform": [0.0, 8.0]},
    }
    folder = tmp_path_factory.mktemp("campaign")
    return short_campaign(folder, draw=draw, laws=["nmpc"], settled_after=2.0)


@pytest.fixture(scope="module")
def rows(campaign):
    """Of flights that each have a solver of their own."""
    flown = []
    for task in TASKS:
        campaign_run._of_thread.kept = None
        flown.append(fly_one(campaign, *task))
    return flown


def test_flights_that_share_a_solver_are_bit_for_bit_those_that_do_not(campaign, rows):
    assert not any(row["error"] for row in rows)
    assert fly_batch(campaign, TASKS) == rows
    assert fly_batch(campaign, TASKS[::-1])[::-1] == rows


def test_one_formulation_serves_all_flights_of_a_thread(campaign):
    one, other = (planned(campaign, number).configuration("nmpc").controller for number in (0, 1))
    kept = shared_formulation(one)
    assert shared_formulation(other) is kept
    assert shared_formulation(planned(campaign, 0).configuration("l1").controller) is None
    assert shared_formulation(one) is kept


def test_the_paper_with_other_weights_is_another_problem(monkeypatch):
    monkeypatch.setattr(campaign_run._of_thread, "kept", None, raising=False)
    one = load_configuration("paper").controller
    kept = shared_formulation(one)
    monkeypatch.setattr(campaign_run, "formulation_of", lambda parameters: "another")
    assert shared_formulation(replace(one, range=160.0)) is kept
    assert shared_formulation(replace(one, state_weights=(1.0,) * 5)) == "another"


def test_two_flights_at_a_time(campaign, rows):
    """Threads share the compiled method and nothing that a solve writes to."""
    with ThreadPoolExecutor(2) as threads:
        flown = list(threads.map(lambda task: fly_one(campaign, *task), TASKS))
    assert flown == rows


def test_a_flight_that_raises_is_a_failure(campaign, monkeypatch):
    def broken(*arguments, **options):
        raise closed_loop.SimulationError("the wing is off")

    monkeypatch.setattr(campaign_run, "simulate", broken)
    row = fly_one(campaign, 0, "nmpc")
    assert (row["failed"], row["reasons"]) == (True, "raised")
    assert row["error"] == "SimulationError: the wing is off"


def test_a_row_says_what_came_of_the_flight(rows):
    row = rows[0]
    assert (row["group"], row["mistake"]) == ("single", "lag")
    assert row["settled_s"] >= 2.0
    assert 0.0 <= row["range_rms_m"] <= row["worst_m"]
    assert row["worst_settled_m"] > 0.0
    assert row["uav_simulator.velocity_noise"] == 0.0
    assert row["target_publisher.motion"] == "stationary"


def test_a_flight_that_is_settled_at_once_has_a_worst_error(tmp_path):
    failure = {"orbit_lost": {"beyond": 1000.0, "settled_for": 0.0}}
    row = fly_one(short_campaign(tmp_path, failure=failure), 0, "l1")
    assert row["settled_s"] == 0.0
    assert row["worst_settled_m"] >= row["worst_m"] > 0.0


@pytest.fixture(scope="module")
def two_laws(tmp_path_factory):
    draw = {**SHORT["draw"], "mission.duration": 4.0}
    folder, laws = tmp_path_factory.mktemp("file"), ["l1", "vector_field"]
    return short_campaign(folder, draw=draw, laws=laws, settled_after=2.0)


@pytest.fixture(scope="module")
def alone(two_laws, tmp_path_factory):
    """Flown by one process, without a break."""
    return run_campaign(two_laws, LocalExecutor(1), tmp_path_factory.mktemp("alone"), show=False)


class Broken(LocalExecutor):
    """Loses its worker after two batches."""

    def run(self, work, shared, batches):
        yield from islice(super().run(work, shared, batches), 2)
        raise WorkerError("lost")


def test_all_draws_are_flown_by_all_laws(two_laws, alone):
    assert [(row["flight"], row["law"]) for row in alone.rows] == [
        (number, law) for number in range(6) for law in ("l1", "vector_field")
    ]
    assert (alone.flown, alone.file.name) == (12, "flights.parquet")
    assert not any(row["error"] for row in alone.rows)
    assert fly_batch(two_laws, [(2, "l1")]) == [alone.rows[4]]  # batches change nothing
    for one, other in zip(alone.rows[::2], alone.rows[1::2], strict=True):
        assert all(one[key] == other[key] for key in two_laws.inputs)


@pytest.mark.long
def test_two_processes_fly_the_same(two_laws, alone, tmp_path):
    """As test/cli/test_campaign.py shows by the command, of a campaign that was killed."""
    results = run_campaign(two_laws, LocalExecutor(2), tmp_path, show=False)
    assert results.file.read_bytes() == alone.file.read_bytes()


def test_what_was_flown_is_not_flown_again(two_laws, alone, tmp_path):
    with pytest.raises(WorkerError, match="lost"):
        run_campaign(two_laws, Broken(1), tmp_path, show=False)
    kept = len(list((tmp_path / "batches").glob("*.parquet")))
    assert kept == 2
    (tmp_path / "batches" / ".half.parquet.tmp").write_bytes(b"PAR1")  # a write that was cut off
    results = run_campaign(two_laws, LocalExecutor(1), tmp_path, show=False)
    assert results.flown == 12 - kept * 3
    assert results.file.read_bytes() == alone.file.read_bytes()
    assert not (tmp_path / "batches").exists()
    again = run_campaign(two_laws, LocalExecutor(1), tmp_path, show=False)
    assert again.flown == 0
    assert again.rows == results.rows


def test_another_campaign_does_not_mix_with_it(two_laws, alone, tmp_path):
    other = short_campaign(tmp_path, seed=9, laws=["l1", "vector_field"])
    with pytest.raises(ParameterError, match="holds flights of another campaign"):
        run_campaign(other, LocalExecutor(1), alone.file.parent, show=False)
    broken = tmp_path / "broken"
    broken.mkdir()
    (broken / "flights.parquet").write_bytes(b"nothing")
    with pytest.raises(ParameterError, match="is no Parquet file of a campaign"):
        run_campaign(two_laws, LocalExecutor(1), broken, show=False)


def test_pandas_and_duckdb_open_it(alone):
    duckdb, pandas = pytest.importorskip("duckdb"), pytest.importorskip("pandas")
    frame = pandas.read_parquet(alone.file)
    assert len(frame) == 12
    assert frame["wind.speed"].between(0.0, 8.0).all()
    query = f"SELECT law, count(*), max(range_rms_m) FROM '{alone.file}' GROUP BY law ORDER BY law"
    found = duckdb.sql(query).fetchall()
    for law, count, worst in found:
        assert count == 6
        assert worst == frame[frame["law"] == law]["range_rms_m"].max()


OTHER_L1 = "from uav_tracking_mpc.laws.l1 import L1Loiter\n\nclass Other(L1Loiter):\n    pass\n"


@pytest.mark.parametrize(
    ("law", "words"),
    [
        ("law.py:Other", "each must have a name of its own"),
        ("pid", "'law' is 'pid', must be one of"),
    ],
)
def test_laws_of_one_name_and_unknown_ones_are_refused(tmp_path, monkeypatch, law, words):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "law.py").write_text(OTHER_L1)
    with pytest.raises(ParameterError, match=words):
        run_campaign(
            short_campaign(tmp_path, laws=["l1", law]), LocalExecutor(1), tmp_path, show=False
        )


def end_abruptly(two_laws, batch):
    os.kill(os.getpid(), signal.SIGKILL)


def test_a_worker_that_is_killed_is_told(two_laws):
    with pytest.raises(WorkerError, match="the same command goes on with what is left"):
        list(LocalExecutor(2).run(end_abruptly, two_laws, [[], []]))


@pytest.fixture
def cluster():
    distributed, dask = map(pytest.importorskip, ("distributed", "dask"))
    # A worker that does not reach its scheduler in time is not started again: the test would hang.
    patient = {f"distributed.comm.timeouts.{name}": "600s" for name in ("connect", "tcp")}
    local = {"n_workers": 2, "threads_per_worker": 1, "host": "127.0.0.1"}
    with (
        dask.config.set(patient),
        distributed.LocalCluster(**local, dashboard_address=None) as cluster,
    ):
        yield cluster


def test_a_cluster_flies_the_same_though_its_workers_are_killed(two_laws, alone, tmp_path, cluster):
    executor = DaskExecutor(cluster.scheduler_address)
    victims = [nanny.pid for nanny in cluster.workers.values()]

    class Killed:
        """Kills each worker once, when a batch has come back."""

        workers, batch = executor.workers, 1

        def run(self, work, two_laws, batches):
            for rows in executor.run(work, two_laws, batches):
                if victims:
                    os.kill(victims.pop(), signal.SIGKILL)
                yield rows

    try:
        results = run_campaign(two_laws, Killed(), tmp_path, show=False)
    finally:
        executor.close()
    assert results.workers == 2
    assert not victims
    assert results.file.read_bytes() == alone.file.read_bytes()


def test_a_cluster_that_is_not_there_is_told():
    dask = pytest.importorskip("dask")
    words = "no Dask scheduler answers at tcp://127.0.0.1:9"
    with (
        dask.config.set({"distributed.comm.timeouts.connect": "1s"}),
        pytest.raises(WorkerError, match=words),
    ):
        DaskExecutor("tcp://127.0.0.1:9")
