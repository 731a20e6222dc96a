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

"""Studies of a configuration with a terminal set: all that is computed of it, and its design."""

from __future__ import annotations

import io
import math
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from uav_tracking_mpc.report.atomic_write import json_text
from uav_tracking_mpc.report.figure_style import BLACK, BLUE, GREEN, OTHERS, VERMILLION, drawing
from uav_tracking_mpc.report.pages import Table
from uav_tracking_mpc.studies.stability.analysis import (
    THEOREMS,
    Analysis,
    LevelBound,
    analyse,
    lowest_violation,
    obstacle,
)
from uav_tracking_mpc.studies.stability.paper_report import (
    numbers_table,
    paper_as_printed,
    paper_report,
    verdicts,
)
from uav_tracking_mpc.studies.stability.proof import (
    BOXES,
    allowed_level,
    certificate,
    limits,
    prove_direct_condition,
)
from uav_tracking_mpc.studies.stability.stability_campaign import (
    COORDINATES,
    UNITS,
    Map,
    attraction_map,
    default_slices,
    fly_local,
    fly_nmpc,
    local_flights,
    random_states,
    save_maps,
)
from uav_tracking_mpc.studies.study import Say, Study, plain
from uav_tracking_mpc.terminal.certificate import problem_parameters
from uav_tracking_mpc.terminal.ingredients import (
    StabilityProblem,
    decrease_excess,
    directions,
    q_star,
)


def as_json(analysis: Analysis) -> dict[str, Any]:
    """The analysis as JSON values; infinities and nan become null.

    Keys that programs may rely on: ``conditions.theorem2``, ``conditions.theorem3`` ({holds, left,
    right}, with the proved L at the terminal level), ``varrho.{theorem3, decrease, inputs,
    certified}`` (all proved), ``lipschitz.{upper, lower}``, ``certified``.
    """
    quantities, direct, reaches = analysis.quantities, analysis.direct, analysis.reaches
    broken = reaches["decrease"].violation
    content = {
        "config": analysis.problem.name,
        "problem": problem_parameters(analysis.problem),
        "horizon": analysis.problem.horizon,
        "certified": analysis.certified,
        "conditions": {
            "level": analysis.lipschitz["level"],
            **{name: theorem(quantities) for name, theorem in THEOREMS.items()},
        },
        "varrho": {
            **{name: reach.proved for name, reach in reaches.items()},
            "inputs": analysis.inputs.level,
            "domain": analysis.domain.level,
            "certified": analysis.level,
        },
        "violated_at": {
            **{name: each.violation and each.violation.level for name, each in reaches.items()},
            "decrease_state": None if broken is None else broken.state.tolist(),
            "decrease_confirmed": analysis.refuted,
        },
        "binding": analysis.binding,
        "lipschitz": analysis.lipschitz,
        "quantities": quantities,
        "gain": analysis.ingredients.gain.tolist(),
        "weight": analysis.ingredients.weight.tolist(),
        "proofs": {
            name: reach.proof and {**reach.proof.statistics, "stopped": reach.proof.stuck}
            for name, reach in reaches.items()
        },
        "verdict": "no terminal set" if direct is None else direct.reason,
    }
    return dict(plain(content))


def as_words(analysis: Analysis) -> str:
    """What was found, in a few lines."""
    problem, orbit, found = analysis.problem, analysis.problem.orbit, analysis.lipschitz
    upper = found["upper"]
    lines = [
        f"{problem.name}: {problem.model} model, {problem.scheme}, T_s = {problem.step:g} s, "
        f"orbit r = {orbit.range:g} m, z = {orbit.altitude:g} m, v = {orbit.speed:g} m/s",
        f"  L(varrho = {found['level']:.4g}) between {found['lower']:.4f} (attained) and "
        f"{upper:.4f} ({'proved' if math.isfinite(upper) else 'not proved: see --boxes'})",
    ]
    for name, theorem in THEOREMS.items():
        condition = theorem(analysis.quantities)
        lines.append(
            "  Theorem {} there: {left:.4f} against {right:.4f}: {}".format(
                name[-1], "holds" if condition["holds"] else "does not hold", **condition
            )
        )
    lines += [
        _reach("(29) of Theorem 2", analysis.reaches["theorem2"]),
        _reach("(41) of Theorem 3", analysis.reaches["theorem3"]),
        _reach("the decrease itself", analysis.reaches["decrease"]),
        f"  U allows varrho = {analysis.inputs.level:.4g} ({analysis.inputs.name})",
    ]
    if analysis.certified:
        lines.append(
            f"  CERTIFIED: x'P_rho x <= {analysis.level:.6g} is a terminal set; "
            f"larger is prevented by {analysis.binding}"
        )
    else:
        lines.append(f"  NOT CERTIFIED: in the way is {analysis.binding}")
        if analysis.direct is not None:
            lines.append(f"  {analysis.direct.reason}")
    return "\n".join(lines)


def _reach(name: str, bound: LevelBound) -> str:
    broken = bound.violation
    known = "no violation known" if broken is None else f"violated at {broken.level:.4g}"
    words = f"  {name}: proved up to varrho = {bound.proved:.4g}, {known}"
    if bound.proof is None or bound.proof.stuck is None:
        return words
    return f"{words}; not proved beyond: {bound.proof.stuck}"


PAIRS = (("range", "bearing"), ("altitude", "path_angle"), ("range", "speed"))


def ellipsoid_figure(problem: StabilityProblem, level: float) -> Figure:
    """Shadows of X_f on pairs of states, with flights of kappa_l that start on its edge.

    Args:
        problem: The configuration.
        level: varrho [-].
    """
    parts = problem.ingredients()
    inverse = np.linalg.inv(parts.weight)
    states = np.sqrt(level) * directions(parts.weight, 12, np.random.default_rng(3))
    paths = local_flights(problem, parts.gain, states, 60)
    turn = np.linspace(0.0, 2.0 * np.pi, 200)
    circle = np.stack([np.cos(turn), np.sin(turn)])
    with drawing(11.0, 3.8) as figure:
        for axes, (first, second) in zip(figure.subplots(1, 3), PAIRS, strict=True):
            i, j = COORDINATES[first], COORDINATES[second]
            # The shadow on (i, j) of x'Px <= level has the matrix (P^-1)_ij,ij.
            block = inverse[np.ix_([i, j], [i, j])]
            edge = np.sqrt(level) * np.linalg.cholesky(block) @ circle
            axes.fill(*edge, alpha=0.15, color=BLUE)
            axes.plot(*edge, color=BLUE)
            axes.plot(paths[:, :, i], paths[:, :, j], lw=0.7, color=VERMILLION)
            axes.plot(paths[0, :, i], paths[0, :, j], "o", ms=3, color=VERMILLION)
            axes.set(xlabel=f"error of {_label(first)}", ylabel=f"error of {_label(second)}")
        figure.suptitle(f"Terminal set at level {level:.4g}, and flights of the local controller")
        figure.tight_layout()
    return figure


def decrease_figure(problem: StabilityProblem, marks: dict[str, float], ceiling: float) -> Figure:
    """Worst decrease over the sphere of each level, and the levels that matter.

    Args:
        problem: The configuration.
        marks: Levels to mark [-], by name.
        ceiling: Largest level shown [-].
    """
    parts = problem.ingredients()
    weight = parts.weight
    excess = decrease_excess(problem, parts)
    rays = directions(weight, 6_000, np.random.default_rng(0))
    levels = np.linspace(0.01, 1.0, 45) * ceiling
    relative = np.array([excess(np.sqrt(level) * rays) / level for level in levels])
    with drawing(8.0, 4.2) as figure:
        axes = figure.add_subplot()
        axes.plot(levels, np.nanmax(relative, axis=1), color=BLUE, label="worst of 6000 directions")
        axes.plot(levels, np.nanmedian(relative, axis=1), color=BLUE, ls="--", label="median")
        axes.axhline(0.0, color=BLACK, lw=0.8)
        for colour, (name, level) in zip((VERMILLION, GREEN, *OTHERS), marks.items(), strict=False):
            axes.axvline(level, color=colour, lw=1.2, label=f"{name}: {level:.3g}")
        axes.set(xlabel="level of the ellipsoid", ylabel="(change of V_f + stage cost) / V_f")
        axes.legend()
        figure.tight_layout()
    return figure


def maps_figure(maps: list[Map]) -> Figure:
    """Maps of X_N: rows of slices, columns of horizons; feasible states are coloured."""
    rows: dict[tuple[str, ...], list[Map]] = {}
    for found in maps:
        rows.setdefault(tuple(found["coordinates"]), []).append(found)
    columns = max(map(len, rows.values()))
    with drawing(3.7 * columns, 3.4 * len(rows)) as figure:
        panels = figure.subplots(len(rows), columns, squeeze=False)
        for row, members in zip(panels, rows.values(), strict=True):
            for axes, member in zip(row, members, strict=False):
                _draw_map(axes, member)
            for axes in row[len(members) :]:
                axes.set_axis_off()
        figure.tight_layout()
    return figure


def _draw_map(axes: Axes, found: Map) -> None:
    axes.pcolormesh(
        found["second"],
        found["first"],
        found["feasible"].astype(float),
        cmap="Blues",
        vmin=0.0,
        vmax=1.6,
        shading="nearest",
        rasterized=True,
    )
    first, second = found["coordinates"]
    x, y = (found["marked"][COORDINATES[name]] for name in (second, first))
    colour, word = (GREEN, "feasible") if found["marked_feasible"] else (VERMILLION, "infeasible")
    axes.plot(x, y, "*", ms=14, color=colour, mec="white", mew=0.8, clip_on=False, zorder=3)
    title = f"N = {found['horizon']}: marked start {word}"
    axes.set(title=title, xlabel=_label(second), ylabel=_label(first))


def _label(coordinate: str) -> str:
    return f"{coordinate.replace('_', ' ')} [{UNITS[coordinate]}]"


HORIZONS = (10, 20, 30)  # of the maps


def stability_study(
    problem: StabilityProblem,
    *,
    boxes: int = BOXES,
    campaign: int = 0,
    points: int = 0,
    pictures: bool = False,
    workers: int | None = None,
    say: Say = lambda _: None,
) -> Study:
    """Analyse a configuration, and fly it where a terminal set is certified.

    Args:
        problem: The configuration.
        boxes: Budget of each proof.
        campaign: Random states to fly; 0 for none.
        points: Of the maps along each coordinate; 0 for no maps.
        pictures: Also draw the ellipsoid and the decrease on it.
        workers: Processes for maps and campaign; all cores by default.
        say: Told in words what is being done.

    Returns:
        The study, with the certificate and the maps among its files.
    """
    analysis = analyse(problem, say, boxes)
    say("the paper, quantity by quantity")
    rows, level = paper_report(), analysis.level
    content = {
        **as_json(analysis),
        "paper_as_printed": paper_as_printed(),
        "paper_report": list(rows),
    }
    words: list[str | Table] = [numbers_table(rows), *verdicts(rows), as_words(analysis)]
    figures: dict[str, Callable[[], Figure]] = {}
    files: dict[str, bytes] = {}
    clean = True
    if analysis.direct is not None and analysis.certified:
        written = certificate(problem, analysis.ingredients, analysis.direct)
        content["certificate_digest"] = written["digest"]
        files["certificate.json"] = (json_text(written) + "\n").encode()
        if campaign:
            states = random_states(problem, level, campaign)
            content["campaign"] = [
                fly_local(problem, level, states),
                fly_nmpc(problem, level, states, workers=workers),
            ]
            words += [f"  campaign {flown}" for flown in content["campaign"]]
            clean = all(flown["clean"] for flown in content["campaign"])
        if points:
            maps = [
                attraction_map(problem, level, where, horizon, workers)
                for where in default_slices(problem, points)
                for horizon in HORIZONS
            ]
            content["maps"] = [
                {
                    "coordinates": found["coordinates"],
                    "horizon": found["horizon"],
                    "feasible_share": float(found["feasible"].mean()),
                    "marked_state": found["marked"].tolist(),
                    "marked_feasible": found["marked_feasible"],
                }
                for found in maps
            ]
            words += [f"  map {found}" for found in content["maps"]]
            archive = io.BytesIO()
            save_maps(maps, archive)
            files["attraction.npz"] = archive.getvalue()
            figures["attraction"] = partial(maps_figure, maps)
        if pictures:
            varrho = content["varrho"]
            marks = {
                "Theorem 3, proved": varrho["theorem3"],
                "U allows, certified": varrho["certified"],
                "decrease, proved": varrho["decrease"],
            }
            ceiling = min(1.15 * max(marks.values()), 0.999 * varrho["domain"])
            figures["ellipsoid"] = partial(ellipsoid_figure, problem, level)
            figures["decrease"] = partial(decrease_figure, problem, marks, ceiling)
    return Study(
        "stability", content, words, figures=figures, files=files, good=analysis.certified and clean
    )


SCALINGS = (1.5, 2.5, 4.0, 8.0)  # -, times P
INPUT_FACTORS = (0.3, 1.0, 3.0, 10.0, 30.0)  # -, times R

# One choice of weights: ``scaling``, rho; ``input_factor``, R over the R asked for; ``level``, the
# varrho that U, the domain and the search for violations allow; ``volume`` of X_f and ``cost``, of
# kappa_l in closed loop from common states, both relative to the choice asked for; ``extents``,
# half-widths of X_f in [m, rad, m, rad, m/s]; ``binding``, the limit that is in the way of a larger
# set; ``proved``, whether the direct condition was, None where it was not tried.
Candidate = dict[str, Any]


def design(
    problem: StabilityProblem,
    say: Say = lambda _: None,
    scalings: tuple[float, ...] = SCALINGS,
    input_factors: tuple[float, ...] = INPUT_FACTORS,
    boxes: int = BOXES,
) -> Study:
    """Search rho and the scale of R against Q for the largest certified region.

    X_f grows in a norm that itself changes with rho, Q and R, so regions are compared by volume:
    that of x'P_rho x <= varrho is proportional to sqrt(varrho^5 / det P_rho). Only the ratio of Q
    to R matters to K, and rho only to the decrease; both move varrho as far as U allows. Against it
    stands the cost of flying: the same flights, scored with the weights that were asked for.

    Args:
        problem: What is asked for.
        say: Told what is being done.
        scalings: Values of rho [-].
        input_factors: Factors of R [-].
        boxes: Budget of each proof.

    Returns:
        Its content: the candidate that is ``asked``; all ``candidates``, largest volume first; the
        ``best``, the largest proved one, or None; ``words``.
    """
    choices = [
        (problem.scaling, 1.0),
        *((scaling, factor) for factor in input_factors for scaling in scalings),
    ]
    raw = []
    for choice in dict.fromkeys(choices):
        say("rho = {:g}, R times {:g}".format(*choice))
        raw.append(_candidate(problem, *choice))
    volume, cost = raw[0]["volume"] or 1.0, raw[0]["cost"]
    for each in raw:
        each |= {"volume": each["volume"] / volume, "cost": each["cost"] / cost}
    asked, ranked, best = {**raw[0]}, sorted(raw, key=lambda each: -each["volume"]), None
    for each in ranked:
        if each["volume"] <= 0.0:
            break
        say("proving rho = {scaling:g}, R times {input_factor:g}".format_map(each))
        changed = changed_problem(problem, each["scaling"], each["input_factor"])
        outcome = prove_direct_condition(changed, changed.ingredients(), each["level"], boxes)
        say(outcome.reason)
        each["proved"] = outcome.holds
        if outcome.holds:
            best = each
            break
    words = _words(problem, asked, best)
    content = {"asked": asked, "candidates": ranked, "best": best, "words": words}
    return Study("design", content, [words, _table(ranked)], good=best is not None)


def changed_problem(
    problem: StabilityProblem, scaling: float, input_factor: float
) -> StabilityProblem:
    """The configuration with another rho [-] and R scaled by a factor [-]."""
    return replace(problem, scaling=scaling, input_weight=input_factor * problem.input_weight)


def _candidate(asked: StabilityProblem, scaling: float, input_factor: float) -> Candidate:
    changed = changed_problem(asked, scaling, input_factor)
    parts = changed.ingredients()
    inputs, domain = limits(changed, parts)
    level = allowed_level(inputs, domain)
    binding = (inputs if inputs.level <= domain.level else domain).name
    if level <= 0.0:
        level, binding = 0.0, obstacle(inputs, domain)
    else:
        found = lowest_violation(decrease_excess(changed, parts), level, rays=3000, starts=6)
        if found is not None and found.level < level:
            level, binding = 0.97 * found.level, "the decrease of V_f"
    return {
        "scaling": scaling,
        "input_factor": input_factor,
        "level": level,
        "volume": float(np.sqrt(level**5 / np.linalg.det(parts.weight))),
        "extents": np.sqrt(level * np.diag(np.linalg.inv(parts.weight))).tolist(),
        "cost": _cost(asked, parts.gain),
        "binding": binding,
        "proved": None,
    }


def _cost(asked: StabilityProblem, gain: np.ndarray, steps: int = 120) -> float:
    """Mean cost of kappa_l in the weights asked for, from states common to all candidates."""
    states = np.sqrt(0.5) * directions(asked.ingredients().weight, 200, np.random.default_rng(0))
    path = local_flights(asked, gain, states, steps - 1)
    cost = np.einsum("tki,ij,tkj->", path, q_star(asked, gain), path) / len(states)
    return float(cost) if np.isfinite(cost) else float("inf")


def _table(candidates: list[Candidate]) -> Table:
    proved = {True: "yes", False: "no", None: "-"}
    rows = [
        [
            f"{each['scaling']:g}",
            f"{each['input_factor']:g}",
            f"{each['level']:.4g}",
            f"{each['volume']:.3g}",
            f"{each['cost']:.3f}",
            proved[each["proved"]],
            each["binding"],
        ]
        for each in candidates
    ]
    headings = ("rho", "R times", "varrho", "volume", "cost", "proved", "limited by")
    return Table(headings, rows, numeric=headings[:5])


def _words(problem: StabilityProblem, asked: Candidate, best: Candidate | None) -> str:
    orbit = problem.orbit
    name = f"orbit r = {orbit.range:g} m, z = {orbit.altitude:g} m, v = {orbit.speed:g} m/s"
    if best is None:
        return (
            f"{name}: no choice of rho and R tried has a certified region. In the way: "
            f"{asked['binding']}."
        )
    units = ("m", "rad", "m", "rad", "m/s")
    pairs = zip(best["extents"], units, strict=True)
    spans = ", ".join(f"{value:.3g} {unit}" for value, unit in pairs)
    return (
        f"{name}: as asked, varrho = {asked['level']:.4g}, limited by {asked['binding']}. Largest "
        f"proved: rho = {best['scaling']:g}, R times {best['input_factor']:g}, "
        f"varrho = {best['level']:.4g}, {best['volume']:.3g} times the volume, half-widths "
        f"{spans}, limited by {best['binding']}; closed-loop cost {best['cost']:.3f} times that "
        "of the choice asked for."
    )
