"""The command `contbed optimise`: the best values of some keys of a scene, by runs of
the scene.

All data is in the folder: an interrupted search continues with the same command and
computes no run twice.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from contbed.errors import ConvergenceError
from contbed.fields import behind
from contbed.many.optimise import files, without_gradients
from contbed.many.optimise.constrained_search import EvaluationFailed, Optimum, minimise
from contbed.many.optimise.evaluations import (
    Evaluation,
    Evaluations,
    OutOfRuns,
    Slice,
    named_values,
)
from contbed.many.optimise.found import Found, costs, found_at
from contbed.many.optimise.problem import Design
from contbed.many.optimise.reading import read_design
from contbed.many.optimise.surrogate import require_sklearn
from contbed.many.optimise.whole import best_choice
from contbed.output.folder import prepare_study
from contbed.output.progress import Progress


@dataclass(frozen=True)
class Optimisation:
    """What a search found, all its evaluations, how many of them were there before,
    and its folder.
    """

    design: Design
    found: Found
    evaluations: Sequence[Evaluation]
    before: int
    folder: Path

    @property
    def failed(self) -> int:
        """How many evaluations failed."""
        return sum(one.functions is None for one in self.evaluations)

    def text(self) -> str:
        """Return the point that was found, its constraints and what they cost, as
        lines.
        """
        found, design = self.found, self.design
        values = named_values(design, found.evaluation.point, found.evaluation.qoi)
        goal = design.objective
        aim = "largest" if design.maximise else "smallest"
        lines = [f"{aim} {goal.text}: {goal(values):.6g}{behind(goal.unit)}"]
        for key, value in zip(design.keys, found.evaluation.point, strict=True):
            lines.append(f"  {key.name} = {key.shown(float(value))}")
        for one, active in zip(design.constraints, found.active, strict=True):
            unit = behind(one.left.unit)
            lines.append(
                f"  {one.text}: "
                f"{one.left(values):.6g}{unit}{', active' if active else ''}"
            )
        return "\n".join([*lines, *(f"  {text}" for text in costs(design, found))])


def optimise(
    design: str | Path,
    out: str | Path | None = None,
    retry_failed: bool = False,
    quiet: bool = True,
    trust: bool = False,
    allow_large: bool = False,
    warn: Callable[[str], None] = lambda text: None,
) -> Optimisation:
    """Search the optimum that a design file asks for.

    Parameters
    ----------
    design : its TOML file
    out : folder for runs, table, plot and the scene of the optimum; results/DESIGN if
        absent
    retry_failed : compute the failed runs again
    quiet : no progress bar
    trust, allow_large : as in `contbed.loading.load`
    warn : is called, before the search, with constraints that seem out of reach

    Raises
    ------
    SceneError : mistakes in the design or its scene; a result that the run does not
        have, a key without derivative
    ConvergenceError : the run at the start failed
    ContbedError : the folder cannot be written; scikit-learn is needed and not
        installed
    """
    todo = read_design(design, trust, allow_large)
    folder = (Path(out) if out else Path("results") / todo.file.stem).absolute()
    if todo.method == "surrogate":
        require_sklearn()
    prepare_study(
        folder, "table.csv", "summary.json", "optimum.toml", "convergence.png"
    )
    evaluations = Evaluations(todo, folder, retry_failed)
    with Progress(todo.runs, "runs", quiet) as progress:

        def tell(now: Evaluations) -> None:
            progress.advance_to(len(now.found))
            files.write_table(folder, todo, now.rows)

        evaluations.told = tell
        first = evaluations.at(todo.start)
        if first.functions is None:
            raise ConvergenceError(
                f"{todo.file}: the run at the start failed: {first.problem}; give a "
                "start of the keys where it does not"
            )
        if todo.method == "surrogate":
            found = without_gradients.search(evaluations)
        else:
            for text in warnings_at_start(evaluations):
                warn(text)
            found = by_gradient(evaluations)
    files.write(folder, todo, found, evaluations)
    return Optimisation(todo, found, evaluations.rows, evaluations.before, folder)


def warnings_at_start(evaluations: Evaluations) -> Iterator[str]:
    """Yield a sentence for each constraint that the gradient at the start does not
    reach within the bounds, a hint before a long search; none with whole keys.

        least excess = g(x_0) + sum_k min(dg/dx_k (low_k - x_k), dg/dx_k (high_k - x_k))

    It is exact where a constraint is linear in the keys; each is taken alone.
    """
    design = evaluations.design
    if not design.constraints or any(key.whole for key in design.keys):
        return
    excess = evaluations.at(design.start).values[1:]
    try:
        slopes = evaluations.derivatives(design.start, range(len(design.keys)))[1:]
    except EvaluationFailed:
        return  # the search reports why
    steps = design.low - design.start, design.high - design.start
    ends = np.stack([slopes * step for step in steps])
    least = excess + ends.min(axis=0).sum(axis=1)
    most = excess + ends.max(axis=0).sum(axis=1)
    short = np.where(design.equality, np.maximum(least, -most), least)
    for one, missed, still in zip(design.constraints, excess, short, strict=True):
        if still > 0.0:
            unit = behind(one.left.unit)
            yield (
                f'{one.at}: "{one.text}" is missed by {abs(missed):.4g}{unit} at the '
                f"start and, by the gradient there, by {still:.4g}{unit} at the best "
                "point within the bounds; widen them or change it if the search does "
                "not find otherwise"
            )


def by_gradient(evaluations: Evaluations) -> Found:
    """Return the optimum by gradients, integers by enumeration or by their
    neighbours.
    """
    design = evaluations.design
    whole = [k for k, key in enumerate(design.keys) if key.whole]
    rest = [k for k, key in enumerate(design.keys) if not key.whole]
    remarks: list[str] = []

    def search(choice: tuple[int, ...], near: Optimum | None) -> Optimum | None:
        held = design.start
        held[whole] = choice
        part = Slice(evaluations, rest, held)
        try:
            if not rest:
                return _only(part)
            found = minimise(part, design.start[rest] if near is None else near.x)
        except EvaluationFailed as error:
            values = [
                f"{design.keys[k].name} = {value}"
                for k, value in zip(whole, choice, strict=True)
            ]
            chosen = f" with {', '.join(values)}" if values else ""
            remarks.append(f"no search{chosen}: {error}")
            return None
        remarks.extend(found.remarks)
        return found

    try:
        if not whole:
            optimum = search((), None)
            text, point = "", None if optimum is None else optimum.x
        else:
            ranges = [
                (int(design.keys[k].low), int(design.keys[k].high)) for k in whole
            ]
            best = best_choice(
                ranges, tuple(int(value) for value in design.start[whole]), search
            )
            optimum = None if best is None else best.optimum
            text = "" if best is None else _how_complete(best.tried, best.complete)
            point = design.start
            if best is not None:
                point[whole], point[rest] = best.choice, best.optimum.x
    except OutOfRuns:
        optimum, point, text = None, None, ""
        remarks.append(
            f"all {design.runs} runs are computed; raise runs and give the same "
            "command to resume"
        )
    return found_at(evaluations, optimum, point, rest, tuple(remarks), text)


def _only(part: Slice) -> Optimum:
    """Return the one point that integers leave."""
    values = part.values(np.zeros(0))
    size = np.where(values[1:] != 0.0, np.abs(values[1:]), 1.0)
    missed = np.where(part.equality, np.abs(values[1:]), values[1:]) / size
    none = np.zeros(0)
    return Optimum(
        none, values, np.zeros((len(values), 0)), np.zeros(len(size)), none, np.zeros(len(size), bool), 0.0,
        float(missed.max(initial=0.0)),
    )  # fmt: skip


def _how_complete(tried: int, complete: bool) -> str:
    if complete:
        return f"all {tried} choices of integers were tried"
    return (
        f"{tried} choices of integers were tried, no neighbour of the best is "
        "better; others were not tried"
    )
