"""The command line."""

import argparse
import json
from dataclasses import replace

import pytest

pytest.importorskip("flint")

from uav_tracking_mpc.studies.stability import command
from uav_tracking_mpc.terminal.stability_problem import paper_problem


def quick(arguments):
    """(11) is proved in a tenth of the time that the exact model takes."""
    if arguments.config == "nowhere":
        raise ValueError("config is 'nowhere', must be one of paper")
    return replace(paper_problem("paper"), name=arguments.config)


def run(*argv):
    parser = argparse.ArgumentParser()
    command.add_parser(parser.add_subparsers(), quick).add_argument("--config")
    arguments = parser.parse_args(["stability", *map(str, argv)])
    return arguments.run(arguments)


def test_json_is_one_object_and_the_certificate_verifies(tmp_path, capsys):
    assert run("--config", "quick", "--json", "--output", tmp_path, "--figures") == 0
    content = json.loads(capsys.readouterr().out)
    assert content["certified"] is True
    assert content["paper_as_printed"]["holds"] is False
    assert content["config"] == "quick"
    assert (tmp_path / "stability.json").exists()
    for name in ("ellipsoid.png", "decrease.png"):
        assert (tmp_path / name).stat().st_size < 300_000
    assert run("--verify", tmp_path / "certificate.json", "--json") == 0
    assert json.loads(capsys.readouterr().out)["accepted"] is True


def test_verify_rejects_a_changed_file(tmp_path, capsys):
    path = tmp_path / "c.json"
    path.write_text("{}")
    assert run("--verify", path) == 1
    assert "REJECTED" in capsys.readouterr().out


def test_unknown_config_is_explained(capsys):
    assert run("--config", "nowhere") == 2
    assert "paper" in capsys.readouterr().err


def test_missing_file_is_explained(tmp_path, capsys):
    assert run("--verify", tmp_path / "none.json") == 2
    assert "none.json" in capsys.readouterr().err
