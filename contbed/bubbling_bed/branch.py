"""Branch of the steady states of a bubbling bed over one value of its scene."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from contbed.bubbling_bed import scene as b
from contbed.bubbling_bed.plan import coefficients
from contbed.bubbling_bed.problem import TYPICAL, BubblingProblem
from contbed.result import Result
from contbed.scene import schema
from contbed.scene.toml_lines import parse_key
from contbed.scene.values import value_at, with_value
from contbed.solvers.branch import Branch, trace


class Family:
    """The equations of a bed as functions of one value of its scene, on one mesh."""

    def __init__(self, problem: BubblingProblem, key: str):
        self.problem, self.key = problem, key

    def at(self, value: float) -> BubblingProblem:
        """Return the problem with that value."""
        scene: b.BubblingScene = with_value(self.problem.plan.scene, parse_key(self.key), value)
        c, _ = coefficients(scene)
        return self.problem.with_coefficients(replace(self.problem.plan, scene=scene, coefficients=c))

    def assemble(self, x: Any, value: float, jacobian: bool) -> tuple[Any, Any]:
        """Assemble the residual and the Jacobian."""
        return self.at(value).steady(x, jacobian)


def follow(problem: BubblingProblem, state: Any, result: Result) -> None:
    """Trace the branch that a state lies on, and report it."""
    table = problem.plan.scene.continuation
    assert table is not None
    family = Family(problem, table.parameter)
    start = float(value_at(problem.plan.scene, table.parameter))
    branch = trace(
        family.assemble,
        problem.unknowns(state),
        start,
        table.to,
        problem.plan.policy,
        weights=problem.weights,
        size=TYPICAL,
        points=table.points,
        back=table.back_to,
        watch=problem.watch,
    )
    if not branch.complete:
        result.warnings.append(
            f"the branch ends at {table.parameter} = {branch.parameter[-1]:.6g} after "
            f"{len(branch.parameter)} points; raise continuation.points"
        )
    result.qoi |= {f"fold_{k}": p for k, (_, p, _) in enumerate(branch.folds, 1)}
    result.tables["continuation"] = columns(problem, family, branch)


def columns(problem: BubblingProblem, family: Family, branch: Branch) -> dict[str, Any]:
    """Return parameter, folds passed, mean temperatures and duties along a branch, folds included as points."""
    points = list(zip(branch.parameter, branch.states, strict=True))
    turns = [index + k for k, (index, _, _) in enumerate(branch.folds)]
    for place, (_, p, x) in zip(turns, branch.folds, strict=True):
        points.insert(place, (p, x))
    unit = schema.unit(schema.of(type(problem.plan.scene)), parse_key(family.key)) or "1"
    rows = []
    for k, (p, x) in enumerate(points):
        at = family.at(p)
        state = at._state(x)
        row = {"point [1]": float(k), f"{family.key} [{unit}]": p, "turns [1]": float(sum(turn < k for turn in turns))}
        row |= {f"T_{name} [K]": mean(at, state, f"T_{name}") for name in at.c.species}
        row |= {f"{name.removesuffix('_W')} [W]": value for name, value in at.duties(state).items()}
        rows.append(row)
    return {header: np.array([row[header] for row in rows]) for header in rows[0]}


def mean(problem: BubblingProblem, state: Any, name: str) -> float:
    """Return the mean of a field over the height."""
    return problem.total(lambda u, o: getattr(u, name), state) / problem.plan.scene.bubbling_bed.height
