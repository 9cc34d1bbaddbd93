"""Branch of the steady states of a reacting bed over one value of its scene, and all
states at a value.
"""

from __future__ import annotations

import itertools
from dataclasses import replace
from typing import Any

import numpy as np

from contbed.arrays import Array
from contbed.errors import ConvergenceError
from contbed.fields import unit_of
from contbed.reacting_bed import cells, solve
from contbed.reacting_bed.problem import Problem
from contbed.reacting_bed.results import at_end, ends, state_at_ends
from contbed.result import Result
from contbed.scene.toml_lines import parse_key
from contbed.scene.values import number_at, with_value
from contbed.solvers.branch import Branch, Way, trace
from contbed.solvers.linear import Policy

# problems of the last values of the parameter, which steps ask for several times
KEPT = 4
SAMPLES = 12  # points of a branch whose errors choose the cells


class Family:
    """The equations of a bed as functions of one value of its scene, on one line of
    cells.
    """

    def __init__(self, problem: Problem, key: str):
        self.problem, self.key = problem, key
        self._known: dict[float, Problem] = {}

    def at(self, value: float) -> Problem:
        """Return the problem with that value; the last ones are kept."""
        if value in self._known:
            return self._known[value]
        scene = with_value(self.problem.scene, parse_key(self.key), value)
        found = Problem.of(scene, self.problem.line.vertices, self.problem.species)
        bed = replace(found.bed, small=self.problem.bed.small)
        if len(self._known) >= KEPT:
            del self._known[next(iter(self._known))]
        self._known[value] = replace(found, bed=bed, line=self.problem.line)
        return self._known[value]

    def assemble(self, x: Any, value: float, jacobian: bool) -> tuple[Any, Any]:
        """Assemble residuals over typical fluxes, and their derivatives to the
        unknowns.
        """
        problem = self.at(value)
        m, N, n = len(problem.names), problem.line.cells, problem.line.degree + 1
        residual, slopes = problem.system.assemble(x.reshape(m, N, n), jacobian)
        scale = self.problem.flux_sizes
        flat = (residual / scale[:, None, None]).ravel()
        if not jacobian:
            return flat, None
        return flat, slopes.matrix(scale)


def follow(problem: Problem, u: Array, result: Result) -> None:
    """Trace the branch that a state lies on, once to choose the cells and once on
    them, and report it.
    """
    table = problem.scene.continuation
    assert table is not None
    family, branch = _traced(problem, u)
    if problem.scene.mesh.cells is None:
        problem, u = _refined(family, branch, problem, u)
        family, branch = _traced(problem, u)
    branch.report(table.parameter, result)
    header = table.header(problem.scene)
    result.tables["continuation"] = branch.columns(
        header, lambda p, x: _leaving(family.at(p), x)
    )
    if table.at is not None:
        states = states_at(family, branch, table.at)
        result.qoi["steady_states_found"] = len(states)
        if states:
            at = family.at(table.at)
            rows = [{header: table.at} | _leaving(at, x) for x in states]
            result.tables["states"] = {
                name: np.array([row[name] for row in rows]) for name in rows[0]
            }
        else:
            result.warnings.append(
                f"the branch has no state at continuation.at = {table.at:.6g}: "
                f"{table.parameter} goes from {min(branch.parameter):.6g} "
                f"to {max(branch.parameter):.6g}"
            )


def _traced(problem: Problem, u: Array) -> tuple[Family, Branch]:
    table = problem.scene.continuation
    assert table is not None
    family = Family(problem, table.parameter)
    start = number_at(problem.scene, table.parameter)
    assert start is not None  # `checks` sees to it

    weights = np.broadcast_to(1.0 / problem.sizes[:, None, None], u.shape).ravel()
    branch = trace(
        family.assemble,
        u.ravel(),
        Way(start, table.to, table.points),
        Policy(1),
        weights=weights,
        size=1.0,
        tolerance=1e-10,
    )
    return family, branch


def _refined(
    family: Family, branch: Branch, problem: Problem, u: Array
) -> tuple[Problem, Array]:
    """Return problem and state on cells that suit points along the branch and its
    folds.
    """
    chosen = np.unique(
        np.linspace(0, len(branch.states) - 1, SAMPLES).round().astype(int)
    )
    points = [(branch.parameter[k], branch.states[k]) for k in chosen] + [
        (p, x) for _, p, x in branch.folds
    ]
    worst = np.zeros(problem.line.cells)
    for p, x in points:
        worst = np.maximum(worst, cells.errors(family.at(p), x.reshape(u.shape)))
    finer = problem.on(cells.better_cells(problem, worst))
    return finer, solve.newton(finer, cells.moved(problem, u, finer), solve.Report())


def states_at(family: Family, branch: Branch, value: float) -> list[Array]:
    """Return all states of a branch at a value, each where the branch crosses it."""
    found: list[Array] = []
    problem = family.at(value)
    shape = (len(problem.names), problem.line.cells, problem.line.degree + 1)
    for (a, x, _), (b, y, _) in itertools.pairwise(branch.points()):
        if (a - value) * (b - value) > 0 or a == b:
            continue
        guess = x + (value - a) / (b - a) * (y - x)
        try:
            state = solve.newton(problem, guess.reshape(shape), solve.Report()).ravel()
        except ConvergenceError:
            continue
        sizes = np.broadcast_to(problem.sizes[:, None, None], shape).ravel()
        if all(np.abs((state - other) / sizes).max() > 1e-6 for other in found):
            found.append(state)
    return found


def _leaving(problem: Problem, x: Array) -> dict[str, float]:
    """Return what leaves at a point of a branch."""
    u = x.reshape(len(problem.names), problem.line.cells, -1)
    end = ends(problem)[0]
    state = state_at_ends(problem, u)
    row = {}
    for name, value in (
        ("T_fluid_out_K", state.T_fluid),
        ("T_solid_out_K", state.T_solid),
    ):
        row[f"{name.removesuffix('_K')} [{unit_of(name)}]"] = at_end(value, end)
    return row | {
        f"x_{name}_out [1]": float(value[end]) for name, value in state.x.items()
    }
