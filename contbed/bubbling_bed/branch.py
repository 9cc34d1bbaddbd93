"""Branch of the steady states of a bubbling bed over one value p of its scene, its
folds and how they move.

At a fold (x_1, p_1) of R(x, p, q) = 0 the left null vector w of dR/dx leaves of a small
change of another value q

    w . dR/dp dp_1 = -w . dR/dq dq

Source: Govaerts 2000, Numerical Methods for Bifurcations of Dynamical Equilibria, SIAM,
    doi:10.1137/1.9780898719543
"""

from __future__ import annotations

from typing import Any

import numpy as np

from contbed.bubbling_bed import scene as b
from contbed.bubbling_bed.problem import RECORDED_FROM, TYPICAL, BubblingProblem
from contbed.bubbling_bed.settling import height_of
from contbed.errors import SceneError
from contbed.fem.ad.batched import RecordedForms
from contbed.fem.ad.graph import Graph
from contbed.result import Result
from contbed.scene.toml_lines import parse_key
from contbed.scene.values import value_at, with_value
from contbed.solvers.branch import Branch, Way, trace
from contbed.solvers.linear import Solver, bordered
from contbed.solvers.tangent import STEP

NEARBY = 1.01  # factor to another value at which recorded forms have to be right
# share of the terms of a balance that rounding of recorded residuals stays far below
ALIKE = 1e-10
# relative change of the height of the bed along a branch from which it warns
OTHER_HEIGHT = 0.02


class Family:
    """The equations of a bed as functions of one value of its scene, on one mesh.

    From the second Jacobian on they are recorded with the value as parameter, where
    coefficients allow it.
    """

    def __init__(self, problem: BubblingProblem, key: str):
        self.problem, self.key = problem, key
        # layers of the mesh are predicted from these numbers; they cost as much as a
        # residual, and the mesh stays
        self.typical = problem.typical()
        # over the value, where that is possible
        self.recorded: RecordedForms | None = None
        self._jacobians, self._tried = 0, False

    def at(self, value: Any) -> BubblingProblem:
        """Return the problem with that value, a number or the parameter of a graph."""
        scene: b.BubblingScene = with_value(
            self.problem.plan.scene, parse_key(self.key), value
        )
        return self.problem.with_scene(scene, self.typical)

    def assemble(self, x: Any, value: float, jacobian: bool) -> tuple[Any, Any]:
        """Assemble the residual and the Jacobian."""
        if jacobian and not self._tried:
            self._jacobians += 1
            if self._jacobians >= RECORDED_FROM:
                self._record(x, value)
        if self.recorded is None:
            return self.at(value).steady(x, jacobian)
        self.recorded.set_parameter(value)
        return self.problem.steady_of(self.recorded, x, jacobian)

    @np.errstate(all="ignore")  # a branch that no state takes may have no value
    def _record(self, x: Any, value: float) -> None:
        """Record the weak forms once for all values, if coefficients do not ask for the
        value.

        Some coefficients might take the parameter for something else, or hold what
        follows from one value: forms with another residual, there or at a value nearby,
        are not used.
        """
        self._tried = True
        if value == 0.0:
            return
        graph = Graph()
        try:
            other = self.at(graph.parameter())
            forms = RecordedForms(other.system, other.forms, graph)
            if all(self._same(forms, x, near) for near in (NEARBY * value, value)):
                self.recorded = forms
        # NotRecordableError, what takes numbers alone, a value too far
        except (TypeError, ValueError, SceneError):
            return

    def _same(self, forms: RecordedForms, x: Any, value: float) -> bool:
        """Whether recorded forms have the residual of the coefficients of a value."""
        forms.set_parameter(value)
        expected, _ = self.at(value).steady(x, False)
        found, matrix = self.problem.steady_of(forms, x, True)
        return bool(
            (np.abs(found - expected) <= ALIKE * (abs(matrix) @ np.abs(x))).all()
        )


def follow(problem: BubblingProblem, state: Any, result: Result) -> Branch:
    """Trace the branch that a state lies on, and report it."""
    table = problem.plan.scene.continuation
    assert table is not None
    family = Family(problem, table.parameter)
    start = float(value_at(problem.plan.scene, table.parameter))
    branch = trace(
        family.assemble,
        problem.unknowns(state),
        Way(start, table.to, table.points, first_fold=table.first_fold),
        problem.plan.policy,
        weights=problem.weights,
        size=TYPICAL,
        watch=problem.watch,
    )
    branch.report(table.parameter, result)
    folds = [p for _, p, _ in branch.folds]
    result.qoi |= distance(problem.plan.scene, folds, branch.complete)
    settles = problem.plan.scene.bubbling_bed.settled_height is not None
    heights: dict[float, float] = {}

    def described(p: float, x: Any) -> dict[str, float]:
        here = family.at(p)
        if settles:
            heights[p] = height_of(here, here._state(x))
        return row(here, x)

    header = table.header(problem.plan.scene)
    result.tables["continuation"] = branch.columns(header, described)
    if settles:
        result.warnings += _other_heights(family, heights)
    return branch


def _other_heights(family: Family, found: dict[float, float]) -> list[str]:
    """Warn where the particles would settle at another height than at the start, which
    the branch keeps; `found` are the heights by the value of the branch.
    """
    kept = family.problem.plan.scene.bubbling_bed.height
    worst = max(found, key=lambda p: abs(found[p] / kept - 1.0))
    if abs(found[worst] / kept - 1.0) < OTHER_HEIGHT:
        return []
    return [
        f"the branch keeps the height of the bed of the scene, {kept:.3g} m, though by "
        f"the bubbles at {family.key} = {worst:.6g} the same particles fill "
        f"{found[worst]:.3g} m: run the scene with that value for the state there"
    ]


def distance(
    scene: b.BubblingScene, folds: list[float], complete: bool
) -> dict[str, float]:
    """Return the relative distance of the scene from the first fold, or from the end of
    a branch without one.

    There is none where the value of the scene is 0, or where the branch was given up
    before a fold.
    """
    table = scene.continuation
    assert table is not None
    start = float(value_at(scene, table.parameter))
    if start == 0.0 or not (folds or complete):
        return {}
    return {"fold_distance": abs((folds[0] if folds else table.to) / start - 1.0)}


class Fold:
    """A fold (x, p) of a bed, with the left null vector w of its Jacobian, where w .
    dR/dp = 1.
    """

    def __init__(self, family: Family, solved: Any, p: float, x: Any):
        self.family, self.p, self.x = family, p, x
        _, matrix = family.assemble(x, p, True)
        step = STEP * abs(p)
        slope = (
            family.assemble(x, p + step, False)[0]
            - family.assemble(x, p - step, False)[0]
        ) / (2.0 * step)
        # any direction will do that is not across the null vector; scaled as the rows
        # of the matrix
        along = as_large_as(matrix, x - solved)
        policy = family.problem.plan.policy
        border = bordered(matrix.T.tocsc(), along, slope, 0.0)
        self.null = Solver(border, policy)(np.append(np.zeros(len(x)), 1.0))[:-1]

    def values(self, problems: list[BubblingProblem]) -> list[float]:
        """Return where the fold lies for the scenes of two problems, a little below
        and above the solved one.
        """
        low, high = (
            Family(one, self.family.key).assemble(self.x, self.p, False)[0]
            for one in problems
        )
        shift = -0.5 * float(self.null @ (high - low))
        return [self.p - shift, self.p + shift]


def as_large_as(matrix: Any, direction: Any) -> Any:
    """Return a direction as long as the largest row of a matrix, so that both are
    one system of like numbers.
    """
    return (
        direction
        * float(abs(matrix).sum(axis=1).max())
        / (float(np.abs(direction).max()) or 1.0)
    )


def row(problem: BubblingProblem, x: Any) -> dict[str, float]:
    """Return mean temperatures and duties of the unknowns of a problem."""
    state = problem._state(x)
    found = {
        f"T_{name} [K]": mean(problem, state, f"T_{name}") for name in problem.c.species
    }
    return found | {
        f"{name.removesuffix('_W')} [W]": value
        for name, value in problem.duties(state).items()
    }


def mean(problem: BubblingProblem, state: Any, name: str) -> float:
    """Return the mean of a field over the height."""
    return (
        problem.total(lambda u, o: getattr(u, name), state)
        / problem.plan.scene.bubbling_bed.height
    )
