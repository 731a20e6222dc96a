"""``uav_tracking stability``: the analysis, its proof, its certificate, from the command line.

With ``--json`` one JSON object goes to stdout and nothing else; progress goes to stderr.
Exit codes: 0 done (``--verify``: accepted), 1 not (rejected, or no certified set), 2 bad usage.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import Any

from uav_tracking_mpc.formulation.paper_problem import SolverFactory, newton_solver
from uav_tracking_mpc.terminal.stability_problem import StabilityProblem

Loader = Callable[[argparse.Namespace], StabilityProblem]
HORIZONS = (10, 20, 30)


def add_parser(
    subparsers: Any, load: Loader, solver: SolverFactory = newton_solver
) -> argparse.ArgumentParser:
    """Add the ``stability`` command.

    Args:
        subparsers: What ``add_subparsers`` returned.
        load: Turns the parsed arguments (its caller adds those that it needs) into a problem;
            raises ValueError with a plain message.
        solver: Makes solvers for maps and campaigns.

    Returns:
        The parser; its ``run`` default takes the parsed arguments and returns the exit code.
    """
    parser = subparsers.add_parser(
        "stability",
        help="the paper's stability analysis, and a proof of the terminal set",
        description="Theorems 2 and 3, the paper beside the truth, a proof of the terminal set.",
    )
    parser.add_argument("--output", type=Path, metavar="DIR", help="write files to this folder")
    parser.add_argument("--json", action="store_true", help="one JSON object on stdout")
    parser.add_argument("--verify", type=Path, metavar="FILE", help="check a certificate")
    parser.add_argument("--design", action="store_true", help="search rho and the weights")
    parser.add_argument("--maps", action="store_true", help="map the domain of attraction")
    parser.add_argument("--points", type=int, default=25, help="of a map along each coordinate")
    parser.add_argument("--campaign", type=int, metavar="COUNT", help="fly random states")
    parser.add_argument("--figures", action="store_true", help="draw the ellipsoid, the decrease")
    parser.add_argument("--errata", type=Path, metavar="FILE", help="write the page on the paper")
    parser.add_argument("--jobs", type=int, default=None, help="processes for maps and campaigns")
    parser.set_defaults(run=lambda arguments: run(arguments, load, solver))
    return parser


def run(
    arguments: argparse.Namespace,
    load: Loader,
    solver: SolverFactory = newton_solver,
) -> int:
    """Do what the arguments say.

    Args:
        arguments: As parsed.
        load: See :func:`add_parser`.
        solver: See :func:`add_parser`.

    Returns:
        Exit code.
    """
    try:
        if arguments.verify is not None:
            return _verify(arguments)
        if arguments.errata is not None:
            from uav_tracking_mpc.studies.stability.paper_report_text import write_page

            write_page(arguments.errata)
            return 0
        problem = load(arguments)
    except (ValueError, OSError) as error:
        print(f"uav_tracking stability: {error}", file=sys.stderr)
        return 2
    if arguments.output is not None:
        arguments.output.mkdir(parents=True, exist_ok=True)
    try:
        if arguments.design:
            return _design(arguments, problem)
        return _analyse(arguments, problem, solver)
    except ImportError as error:
        print(f"uav_tracking stability: {error}", file=sys.stderr)
        return 2


def _say(text: str) -> None:
    print(text, file=sys.stderr, flush=True)


def _print_json(content: Any) -> None:
    print(json.dumps(content, indent=1, allow_nan=False))


def _verify(arguments: argparse.Namespace) -> int:
    from uav_tracking_mpc.terminal.verify import verify

    content = json.loads(arguments.verify.read_text())
    reason = "no JSON object" if not isinstance(content, dict) else verify(content)
    if arguments.json:
        _print_json({"file": str(arguments.verify), "accepted": reason is None, "reason": reason})
    elif reason is None:
        print(f"accepted: x'P_rho x <= {content['level']:.6g} is a terminal set")
    else:
        print(f"REJECTED: {reason}")
    return 0 if reason is None else 1


def _design(arguments: argparse.Namespace, problem: StabilityProblem) -> int:
    from uav_tracking_mpc.studies.stability.design import design

    found = design(problem, _say)
    content = asdict(found)
    if arguments.output is not None:
        (arguments.output / "design.json").write_text(json.dumps(content, indent=1) + "\n")
    if arguments.json:
        _print_json(content)
    else:
        print(found.words)
        print("rho    R times  varrho    volume   cost    proved  limited by")
        for c in found.candidates:
            proved = {True: "yes", False: "no", None: "-"}[c.proved]
            print(
                f"{c.scaling:<6g} {c.input_factor:<8g} {c.level:<9.4g} {c.volume:<8.3g} "
                f"{c.cost:<7.3f} {proved:<7} {c.binding}"
            )
    return 0 if found.best is not None else 1


def _analyse(
    arguments: argparse.Namespace, problem: StabilityProblem, solver: SolverFactory
) -> int:
    from uav_tracking_mpc.studies.stability import analysis_text, paper_report, paper_report_text
    from uav_tracking_mpc.studies.stability.analysis import analyse
    from uav_tracking_mpc.terminal.certificate import certificate, write_certificate

    result = analyse(problem, _say)
    content = analysis_text.as_json(result)
    _say("the paper, quantity by quantity")
    rows = paper_report.paper_report()
    content["paper_as_printed"] = paper_report.paper_as_printed()
    content["paper_report"] = paper_report_text.as_json(rows)
    written = None
    if result.direct is not None and result.certified:
        written = certificate(problem, result.ingredients, result.direct)
        content["certificate_digest"] = written["digest"]
    level = result.level
    if arguments.campaign and level > 0.0:
        content["campaign"] = _campaign(arguments, problem, level, solver)
    if arguments.maps and level > 0.0:
        content["maps"] = _maps(arguments, problem, level, solver)
    if arguments.output is not None:
        if written is not None:
            write_certificate(written, arguments.output / "certificate.json")
        if arguments.figures and level > 0.0:
            _figures(arguments.output, problem, content)
        (arguments.output / "stability.json").write_text(json.dumps(content, indent=1) + "\n")
    if arguments.json:
        _print_json(content)
    else:
        from rich.console import Console

        console = Console()
        console.print(paper_report_text.as_table(rows))
        for line in paper_report_text.verdicts(rows):
            console.print(line, markup=False, highlight=False)
        print(analysis_text.as_words(result))
        for entry in content.get("campaign", []):
            print(f"  campaign {entry}")
        for entry in content.get("maps", []):
            print(f"  map {entry}")
    return 0 if result.certified else 1


def _campaign(
    arguments: argparse.Namespace, problem: StabilityProblem, level: float, solver: SolverFactory
) -> list[dict[str, Any]]:
    from uav_tracking_mpc.studies.stability.ellipsoid_campaign import (
        fly_local,
        fly_nmpc,
        random_states,
    )

    states = random_states(problem, level, arguments.campaign)
    results = (
        fly_local(problem, level, states),
        fly_nmpc(problem, level, states, solver=solver, workers=arguments.jobs),
    )
    return [{**asdict(result), "clean": result.clean} for result in results]


def _maps(
    arguments: argparse.Namespace, problem: StabilityProblem, level: float, solver: SolverFactory
) -> list[dict[str, Any]]:
    from uav_tracking_mpc.studies.stability.attraction import (
        attraction_map,
        default_slices,
        save_maps,
    )
    from uav_tracking_mpc.studies.stability.stability_figures import maps_figure

    maps = [
        attraction_map(problem, level, where, horizon, solver, workers=arguments.jobs)
        for where in default_slices(problem, arguments.points)
        for horizon in HORIZONS
    ]
    if arguments.output is not None:
        save_maps(maps, str(arguments.output / "attraction.npz"))
        maps_figure(maps, arguments.output / "attraction.png")
    return [
        {
            "coordinates": [m.slice.first, m.slice.second],
            "horizon": m.horizon,
            "feasible_share": float(m.feasible.mean()),
            "marked_state": m.marked.tolist(),
            "marked_feasible": m.marked_feasible,
        }
        for m in maps
    ]


def _figures(output: Path, problem: StabilityProblem, content: dict[str, Any]) -> None:
    from uav_tracking_mpc.studies.stability.stability_figures import (
        decrease_figure,
        ellipsoid_figure,
    )

    varrho = content["varrho"]
    ellipsoid_figure(problem, varrho["certified"], output / "ellipsoid.png")
    marks = {
        "Theorem 3, proved": varrho["theorem3"],
        "U allows, certified": varrho["certified"],
        "decrease, proved": varrho["decrease"],
    }
    ceiling = 1.15 * max(marks.values())
    decrease_figure(problem, marks, min(ceiling, 0.999 * varrho["domain"]), output / "decrease.png")
