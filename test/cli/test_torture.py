"""A short campaign with real nodes: nothing may break."""

import json
import subprocess

import pytest
from processes import TERMINATE, command, environment, nodes_of, wait_for

pytestmark = pytest.mark.nodes


def torture(*arguments):
    own = {key: value for key, value in environment().items() if key != "ROS_DOMAIN_ID"}
    return subprocess.Popen(
        command("cli.main", "torture", *map(str, arguments)),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=own,
    )


@pytest.mark.timeout(240)
def test_a_minute_of_faults_breaks_nothing(tmp_path):
    process = torture("--minutes", 1, "--seed", 0, "--output", tmp_path, "--json")
    output, errors = process.communicate(timeout=200)
    summary = json.loads(output)
    told = {"failing": summary["failing_cases"], "errors": errors}
    assert process.returncode == 0, told
    assert summary["violations"] == summary["deaths"] == 0, told
    assert summary["faults"] >= 20
    assert summary["kinds"] >= 15
    assert summary["worst_recovery_s"] <= 30.0
    assert {"kill_uav_simulator", "kill_target_publisher"} <= set(summary["per_kind"])
    assert json.loads((tmp_path / "torture.json").read_text()) == summary
    assert (tmp_path / "timeline.png").read_bytes().startswith(b"\x89PNG")
    assert "Traceback" not in errors + (tmp_path / "nodes.log").read_text()


@pytest.mark.timeout(120)
def test_what_is_violated_is_found_told_and_kept(tmp_path):
    """A floor that the orbit lies below: the observer must see it, whoever is to blame."""
    from uav_tracking_mpc.nodes.flight_bag import messages
    from uav_tracking_mpc.studies.faults.case_bag import TOPICS

    low = [
        "--config",
        "paper",
        "--set",
        "target_publisher.position=[0,0,60]",
        "--set",
        "nmpc_controller.altitude=-50.0",
    ]
    process = torture("--minutes", 1, "--case", 0, *low, "--output", tmp_path)
    output, errors = process.communicate(timeout=100)
    assert process.returncode == 1, errors
    assert "altitude floor" in output
    (bag,) = (tmp_path / "cases").glob("case_0000.mcap")
    heard = {topic.name for topic, _, _ in messages(bag, *TOPICS)}
    assert {"raw/uav/odometry", "uav/odometry", "raw/uav/command", "torture/fault"} <= heard


@pytest.mark.timeout(60)
def test_a_campaign_may_be_ended_and_leaves_nobody(tmp_path):
    process = torture("--minutes", 5, "--output", tmp_path)
    try:
        assert wait_for(lambda: len(nodes_of(process.pid)) == 3, 20.0)
        nodes = nodes_of(process.pid)
        process.send_signal(TERMINATE)
        _, errors = process.communicate(timeout=30)
    finally:
        process.kill()
    assert process.returncode == 130
    assert errors.strip().endswith("uav_tracking: interrupted")
    assert not nodes_of(process.pid)
    assert len(nodes) == 3
