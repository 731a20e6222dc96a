"""``uav_tracking benchmark``: solve times of this package's solver and of others."""

from __future__ import annotations

import argparse

from uav_tracking_mpc.cli.answer import answer
from uav_tracking_mpc.cli.arguments import add_output_arguments, number

HELP = "time the solver against CasADi with fatrop and IPOPT"
DESCRIPTION = (
    "Time the solver against others: same problems, same starts, one run. Exit code 0 if it "
    "converged from at least 99 % of the cold starts of every case."
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options.

    Args:
        parser: Of this command.
    """
    parser.add_argument(
        "--config", default="paper", choices=["paper"], help="parameters of the paper's cases"
    )
    add_output_arguments(parser, "benchmark.json and solve_time.png")
    count = number(int, 1)
    parser.add_argument(
        "--cold", type=count, default=2000, help="random cold starts for this package's solver"
    )
    parser.add_argument(
        "--peers-cold", type=count, default=20, help="how many of them the others solve as well"
    )
    parser.add_argument("--seed", type=int, default=0, help="of the random states")
    parser.add_argument("--quick", action="store_true", help="few repetitions, no figure")


def run(arguments: argparse.Namespace) -> int:
    """Run the benchmark.

    Args:
        arguments: As parsed.

    Returns:
        Exit code.
    """
    from uav_tracking_mpc.studies.benchmark.benchmark_report import converged, in_words, save
    from uav_tracking_mpc.studies.benchmark.benchmark_study import benchmark

    results = benchmark(
        cold=arguments.cold,
        peers_cold=arguments.peers_cold,
        seed=arguments.seed,
        quick=arguments.quick,
    )
    words = in_words(results)
    if arguments.output is not None:
        save(results, arguments.output)
        words.append(f"saved in {arguments.output}")
    answer(results, words, arguments.json)
    return 0 if converged(results) else 1
