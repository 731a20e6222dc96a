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

"""``uav_tracking benchmark``: solve times of this package's solver and of others."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from uav_tracking_mpc.cli.options import add_output_arguments, number
from uav_tracking_mpc.cli.program import publish

if TYPE_CHECKING:
    from uav_tracking_mpc.studies.benchmark.benchmark_study import Peers
    from uav_tracking_mpc.studies.study import Study

HELP = "time the solver against fatrop and IPOPT"
DESCRIPTION = (
    "Time the solver against others: same problems, same starts, one run. Exit code 0 if it "
    "converged from at least 99 % of the cold starts of every case."
)

NODES_OVERRIDES = ("nmpc_controller.control_rate=50.0", "uav_simulator.state_rate=50.0")
NODES_TIME = {False: 60.0, True: 10.0}  # s, with and without --quick
VIEWED_AIRCRAFT = (1, 3)  # how many are timed


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options.

    Args:
        parser: Of this command.
    """
    add_output_arguments(parser, "benchmark.json and solve_time.png")
    count = number(int, 1)
    parser.add_argument(
        "--cold",
        type=count,
        default=2000,
        metavar="N",
        help="random cold starts for this package's solver",
    )
    parser.add_argument(
        "--peers-cold",
        type=count,
        default=20,
        metavar="N",
        help="how many of them the others solve as well",
    )
    parser.add_argument(
        "--seed", type=number(int, 0), default=0, metavar="N", help="of the random states"
    )
    parser.add_argument(
        "--start",
        action="store_true",
        help="instead, time from the start of processes to the first optimal plan",
    )
    parser.add_argument("--quick", action="store_true", help="few repetitions, no figure")
    parser.add_argument(
        "--nodes",
        action="store_true",
        help="instead: fly small_uav in wind at 50 Hz with three real nodes, and time them from a "
        "state to its command, beside an echo of the same messages",
    )
    parser.add_argument(
        "--view",
        nargs="?",
        type=number(float, 1.0),
        const=0.0,
        metavar="SECONDS",
        help="with --nodes: time them in turns without and with a page that shows the flight, for "
        "one aircraft and for three; a turn lasts SECONDS (default: 60, with --quick 10)",
    )


def run(arguments: argparse.Namespace, peers: Peers | None = None) -> int:
    """Run the benchmark.

    Args:
        arguments: As parsed.
        peers: Further solvers; none by default.

    Returns:
        Exit code.
    """
    if arguments.nodes or arguments.view is not None:
        return publish(_nodes(arguments), arguments)
    if arguments.start:
        from uav_tracking_mpc.studies.benchmark.start_timing import start_timing

        return publish(start_timing(repetitions=1 if arguments.quick else 5), arguments)
    from uav_tracking_mpc.studies.benchmark.benchmark_study import benchmark, benchmark_study

    results = benchmark(
        cold=arguments.cold,
        peers_cold=arguments.peers_cold,
        seed=arguments.seed,
        quick=arguments.quick,
        peers=peers,
    )
    return publish(benchmark_study(results), arguments)


def _nodes(arguments: argparse.Namespace) -> Study:
    from rich.console import Console

    from uav_tracking_mpc.settings.configuration import load_configuration
    from uav_tracking_mpc.studies.benchmark.node_latency import node_latency, watched_latency

    configuration = load_configuration("small_uav", NODES_OVERRIDES, "crosswind")
    duration = arguments.view or NODES_TIME[arguments.quick]
    with Console(stderr=True).status("nodes") as status:
        if arguments.view is None:
            return node_latency(configuration, duration, status.update)
        return watched_latency(configuration, VIEWED_AIRCRAFT, duration, status.update)
