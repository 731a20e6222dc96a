"""How nodes end: exit codes and last words, as processes."""

import pytest
from processes import INTERRUPT, TERMINATE, run_node

pytestmark = pytest.mark.nodes


NODES = ("uav_simulator", "target_publisher", "nmpc_controller")
FIRST_WORDS = {
    "uav_simulator": "waiting for the first command",
    "target_publisher": "target is stationary",
    "nmpc_controller": "orbit of 150 m",
}


@pytest.mark.parametrize("stop", [INTERRUPT, TERMINATE])
@pytest.mark.parametrize("node", NODES)
def test_signals_end_a_node_cleanly(node, stop):
    code, output = run_node(node, stop=stop, after=FIRST_WORDS[node])
    assert code == 0, output
    assert "Traceback" not in output


@pytest.mark.parametrize(
    ("node", "arguments", "words"),
    [
        ("nmpc_controller", ["-p", "range:=far"], "parameter 'range' is 'far'"),
        ("nmpc_controller", ["-p", "state_weights:=[]"], "a list of 5 numbers"),
        ("uav_simulator", ["-p", "speed_max:=-1.0"], "parameter 'speed_max' is -1.0"),
        ("target_publisher", ["-p", "rate:=.nan"], "parameter 'rate' is nan"),
        ("target_publisher", ["-p", "nonsense"], "Couldn't parse parameter override"),
        ("uav_simulator", ["--params-file", "/nowhere.yaml"], "/nowhere.yaml"),
    ],
)
def test_bad_parameters_end_in_one_fatal_line_and_code_2(node, arguments, words):
    code, output = run_node(node, "--ros-args", *arguments)
    fatal = [line for line in output.splitlines() if line.startswith(f"[FATAL] [{node}]: ")]
    assert code == 2
    assert len(fatal) == 1
    assert words in fatal[0]
    assert "Traceback" not in output


def test_misspelt_parameters_are_warned_of():
    code, output = run_node(
        "target_publisher", "--ros-args", "-p", "raet:=5.0", stop=INTERRUPT, after="stationary"
    )
    assert code == 0
    assert "parameter 'raet' is unknown and has no effect" in output


def test_a_configuration_serves_nodes_in_any_namespace(tmp_path):
    file = tmp_path / "configuration.yaml"
    file.write_text("/**/nmpc_controller: {ros__parameters: {range: 160.0}}")
    arguments = ["--params-file", str(file), "-r", "__ns:=/red"]
    code, output = run_node(
        "nmpc_controller", "--ros-args", *arguments, stop=INTERRUPT, after="orbit of 160 m"
    )
    assert code == 0
    assert "red.nmpc_controller" in output
