"""Amounts of gases and solids of a state: over their sizes, the least of each cell, and what is said below zero."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from contbed.reacting_bed.equations.bed import conserved
from contbed.reacting_bed.problem import Problem

Array = NDArray[np.float64]
SAMPLES = 13  # points of a cell at which amounts are looked at, ends included, beside the nodes


class Least(NamedTuple):
    """The least amount of a run: over the size of its field, the field, and where [m] and when [s] it was."""

    value: float = 0.0
    field: float = 0.0  # a number, as all are in a checkpoint
    x: float = 0.0
    time: float = math.nan  # of a steady state


def carried(problem: Problem) -> Array:
    """Return what flux amounts of gases and solids have per value, 0 for what is no amount or is at rest (m,)."""
    of = problem.bed.velocity_of
    speeds = {"g": lambda _: 1.0, "n": lambda name: abs(of(name))}
    return np.array([speeds.get(name.split("_")[0], lambda _: 0.0)(name) for name in problem.names])


def along(problem: Problem, u: Array) -> Array:
    """Return the unknowns over their sizes, those of gas along its stream (m, N, p + 1)."""
    gas = 1.0 if problem.streams.ahead else -1.0
    signs = np.array([gas if name.startswith("g_") else 1.0 for name in problem.names])
    found: Array = u * (signs / problem.sizes)[:, None, None]
    return found


def lowest(problem: Problem, u: Array) -> Array:
    """Return the least value of each field in each cell, over its size and along its stream (m, N)."""
    values = along(problem, u)
    between = values @ problem.line.basis(np.linspace(0.0, 1.0, SAMPLES)).T
    found: Array = np.minimum(values.min(axis=2), between.min(axis=2))
    return found


def least(problem: Problem, u: Array, time: float = math.nan) -> Least:
    """Return the least of all gases and solids of a state, those at rest included."""
    rows = [k for k, name in enumerate(problem.names) if name.startswith(("g_", "n_"))]
    low = lowest(problem, u)[rows]
    row, cell = divmod(int(low.argmin()), low.shape[1])
    x = float(problem.line.points[cell].mean())
    return Least(float(low[row, cell]), float(rows[row]), x, time)


def below_zero(problem: Problem, found: Least) -> str | None:
    """Return what a user is told of the least amount; None where it is within the errors that the scene allows."""
    time, solver = problem.scene.time, problem.scene.solver
    allowed = solver.tolerance if time is None else time.tolerance
    if not found.value < -allowed:
        return None
    name = problem.names[int(found.field)]
    of, when, key = "gas" if name.startswith("g_") else "solids", "", "solver.tolerance"
    if time is not None:
        when, key = f" at t = {found.time:.4g} s", "time.tolerance"
    return (
        f"{conserved(name)} falls to {found.value:.2g} of the {of} at x = {found.x:.4g} m{when}, further below zero "
        f"than {key} = {allowed:g}: use more mesh.cells, or a smaller {key}"
    )
