import json

import pytest

from uav_tracking_mpc.cli.main import main


def test_stability_says_what_is_guaranteed(capsys):
    assert main(["stability", "--config", "small_uav"]) == 0
    text = capsys.readouterr().out
    assert "Guaranteed." in text
    assert "Not guaranteed." in text
    assert "ellipsoid" in text


def test_a_campaign_is_one_object(tmp_path, capsys):
    arguments = ["--campaign", "2", "--jobs", "1", "--json", "--output", str(tmp_path)]
    assert main(["stability", "--config", "small_uav", *arguments]) == 0
    content = json.loads(capsys.readouterr().out)
    assert content["terminal_constraint"] == "artificial_orbit"
    assert (content["states"], content["steps"]) == (2, 80)
    assert json.loads((tmp_path / "stability.json").read_text()) == content


@pytest.mark.parametrize("option", ["--design", "--maps", "--figures"])
def test_what_belongs_to_the_ellipsoid_is_refused(option, capsys):
    assert main(["stability", "--config", "small_uav", option]) == 2
    assert f"{option} is about the ellipsoid" in capsys.readouterr().err
