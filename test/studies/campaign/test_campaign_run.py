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

"""The outcome does not depend on who flies it, nor on how often it was interrupted."""

import os
import signal

import pytest
from campaign_files import short_campaign

from uav_tracking_mpc.parameters.specification import ParameterError
from uav_tracking_mpc.studies.campaign.campaign_run import run_campaign
from uav_tracking_mpc.studies.campaign.executors import CampaignError, DaskExecutor, LocalExecutor
from uav_tracking_mpc.studies.campaign.one_flight import fly_batch


@pytest.fixture(scope="module")
def campaign(tmp_path_factory):
    return short_campaign(tmp_path_factory.mktemp("file"), laws=["l1", "vector_field"])


@pytest.fixture(scope="module")
def alone(campaign, tmp_path_factory):
    """Flown by one process, without a break."""
    return run_campaign(campaign, LocalExecutor(1), tmp_path_factory.mktemp("alone"), show=False)


class Broken(LocalExecutor):
    """Loses its worker after some batches."""

    def __init__(self, after):
        super().__init__(1)
        self.after = after

    def run(self, work, campaign, batches):
        for index, result in enumerate(super().run(work, campaign, batches)):
            if index == self.after:
                raise CampaignError("lost")
            yield result


def test_all_draws_are_flown_by_all_laws(campaign, alone):
    assert [(row["flight"], row["law"]) for row in alone.rows] == [
        (number, law) for number in range(6) for law in ("l1", "vector_field")
    ]
    assert (alone.flown, alone.file.name) == (12, "flights.parquet")
    assert not any(row["error"] for row in alone.rows)
    for one, other in zip(alone.rows[::2], alone.rows[1::2], strict=True):
        assert all(one[key] == other[key] for key in campaign.inputs)


def test_two_processes_fly_the_same(campaign, alone, tmp_path):
    results = run_campaign(campaign, LocalExecutor(2), tmp_path, show=False)
    assert results.file.read_bytes() == alone.file.read_bytes()


def test_what_was_flown_is_not_flown_again(campaign, alone, tmp_path):
    with pytest.raises(CampaignError, match="lost"):
        run_campaign(campaign, Broken(2), tmp_path, show=False)
    kept = len(list((tmp_path / "batches").glob("*.parquet")))
    assert kept == 2
    (tmp_path / "batches" / ".half.parquet.tmp").write_bytes(b"PAR1")  # a write that was cut off
    results = run_campaign(campaign, LocalExecutor(1), tmp_path, show=False)
    assert results.flown == 12 - kept * 3
    assert results.file.read_bytes() == alone.file.read_bytes()
    assert not (tmp_path / "batches").exists()
    again = run_campaign(campaign, LocalExecutor(1), tmp_path, show=False)
    assert again.flown == 0
    assert again.rows == results.rows


def test_another_campaign_does_not_mix_with_it(campaign, alone, tmp_path):
    other = short_campaign(tmp_path, seed=9, laws=["l1", "vector_field"])
    with pytest.raises(ParameterError, match="holds flights of another campaign"):
        run_campaign(other, LocalExecutor(1), alone.file.parent, show=False)
    broken = tmp_path / "broken"
    broken.mkdir()
    (broken / "flights.parquet").write_bytes(b"nothing")
    with pytest.raises(ParameterError, match="is no Parquet file of a campaign"):
        run_campaign(campaign, LocalExecutor(1), broken, show=False)


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


def test_two_laws_of_one_name_are_refused(tmp_path):
    law = tmp_path / "law.py"
    law.write_text(
        "from uav_tracking_mpc.laws.l1 import L1Loiter\n\nclass Other(L1Loiter):\n    pass\n"
    )
    campaign = short_campaign(tmp_path, laws=["l1", f"{law}:Other"])
    with pytest.raises(ParameterError, match="each must have a name of its own"):
        run_campaign(campaign, LocalExecutor(1), tmp_path / "out", show=False)


def test_a_law_that_nobody_knows_is_refused(tmp_path):
    campaign = short_campaign(tmp_path, laws=["l1", "pid"])
    with pytest.raises(ParameterError, match="'law' is 'pid', must be one of"):
        run_campaign(campaign, LocalExecutor(1), tmp_path / "out", show=False)


def end_abruptly(campaign, batch):
    os.kill(os.getpid(), signal.SIGKILL)


def test_a_worker_that_is_killed_is_told(campaign):
    with pytest.raises(CampaignError, match="the same command goes on with what is left"):
        list(LocalExecutor(2).run(end_abruptly, campaign, [[], []]))


@pytest.fixture
def cluster():
    distributed = pytest.importorskip("distributed")
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, host="127.0.0.1", dashboard_address=None
    ) as cluster:
        yield cluster


def test_a_cluster_flies_the_same_though_its_workers_are_killed(campaign, alone, tmp_path, cluster):
    executor = DaskExecutor(cluster.scheduler_address)
    victims = [nanny.pid for nanny in cluster.workers.values()]

    class Killed:
        """Kills each worker once, when a batch has come back."""

        workers, batch = executor.workers, 1

        def run(self, work, campaign, batches):
            for rows in executor.run(work, campaign, batches):
                if victims:
                    os.kill(victims.pop(), signal.SIGKILL)
                yield rows

    try:
        results = run_campaign(campaign, Killed(), tmp_path, show=False)
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
        pytest.raises(CampaignError, match=words),
    ):
        DaskExecutor("tcp://127.0.0.1:9")


def test_batches_do_not_change_what_is_flown(campaign, alone):
    tasks = [(row["flight"], row["law"]) for row in alone.rows[3:6]]
    flown = fly_batch(campaign, tasks)
    assert flown == [{key: row[key] for key in flown[0]} for row in alone.rows[3:6]]
