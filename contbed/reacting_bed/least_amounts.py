"""Amounts of gases and solids of a state: over their sizes, the least of each cell,
and what is said below zero.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from contbed.arrays import Array, Flags
from contbed.fem.line_dg import Line
from contbed.reacting_bed.equations.unknowns import Role
from contbed.reacting_bed.problem import Problem
from contbed.reacting_bed.scene import ReactingScene

# of a deviation from the mean that is seen at the points of `Line.finely_sampled`, the
# largest between them
MISSED = 1.002


class Least(NamedTuple):
    """The least amount of a run: over the size of its field, the field, and
    where [m] and when [s] it was.
    """

    value: float = 0.0
    field: float = 0.0  # a number, as all are in a checkpoint
    x: float = 0.0
    time: float = math.nan  # of a steady state


def carried(problem: Problem) -> Array:
    """Return what flux amounts of gases and solids have per value, 0 for what is no
    amount or is at rest (m,).
    """
    speeds = np.zeros(len(problem.unknowns))
    speeds[problem.rows(Role.GAS)] = 1.0
    for k in problem.rows(Role.SOLID):
        speeds[k] = abs(problem.bed.velocity_of(problem.names[k]))
    return speeds


def at_rest(problem: Problem) -> Flags:
    """Return which unknowns are solids at rest, whose amounts at nodes know nothing
    of each other (m,).
    """
    of = problem.bed.velocity_of
    return np.array(
        [each.role is Role.SOLID and not of(each.name) for each in problem.unknowns]
    )


def along(problem: Problem, u: Array) -> Array:
    """Return the unknowns over their sizes, those of gas along its stream (m, N,
    p + 1).
    """
    found: Array = u * (problem.gas_signs / problem.sizes)[:, None, None]
    return found


def lowest(problem: Problem, u: Array) -> Array:
    """Return the least value of each field in each cell, over its size and along its
    stream (m, N).

    Solids at rest are looked at where they are known, at the nodes.
    """
    values = along(problem, u)
    between = values @ problem.line.sampled.T
    at_nodes = values.min(axis=2)
    found: Array = np.where(
        at_rest(problem)[:, None], at_nodes, np.minimum(at_nodes, between.min(axis=2))
    )
    return found


def between_nodes(problem: Problem, u: Array) -> Array:
    """Return a state as it is shown between nodes: solids at rest not below zero there,
    with the same in each cell.

    Polynomials through nodes of a front are brought nearer to their means, those of all
    solids by one share, so that what they hold together stays.
    """
    rest = np.flatnonzero(at_rest(problem))
    least = problem.scene.solver.newton_tolerance * problem.sizes[rest]
    share = share_above_zero(problem.line, u[rest], least).min(axis=0, initial=1.0)
    if (share == 1.0).all():
        return u
    out = u.copy()
    out[rest] = nearer_to_means(problem.line, u[rest], share)
    return out


def share_above_zero(line: Line, values: Array, least: Array) -> Array:
    """Return by how much polynomials (..., N, p + 1) may deviate from their means, so
    that none is below zero between its nodes (..., N).

    1 where they are not below zero by more than `least` (...,).
    """
    low = (values @ line.finely_sampled.T).min(axis=-1)
    wrong = low < -least[..., None]
    mean = values @ line.weights
    falls = wrong & (mean > low)  # a constant below zero has no share
    share = np.clip(mean / np.where(falls, MISSED * (mean - low), 1.0), 0.0, 1.0)
    found: Array = np.where(wrong, share, 1.0)
    return found


def nearer_to_means(line: Line, values: Array, share: Array) -> Array:
    """Return polynomials (..., N, p + 1) with a share of their deviations from the means
    of cells.
    """
    mean = (values @ line.weights)[..., None]
    found: Array = mean + share[..., None] * (values - mean)
    return found


def least(problem: Problem, u: Array, time: float = math.nan) -> Least:
    """Return the least of all gases and solids of a state, those at rest included."""
    rows = problem.rows(Role.GAS, Role.SOLID)
    low = lowest(problem, u)[rows]
    row, cell = divmod(int(low.argmin()), low.shape[1])
    x = float(problem.line.points[cell].mean())
    return Least(float(low[row, cell]), float(rows[row]), x, time)


def allowed(scene: ReactingScene) -> float:
    """Return the share of its size to which an amount may err."""
    return scene.solver.tolerance if scene.time is None else scene.time.tolerance


def finer(scene: ReactingScene) -> str:
    """Return what gives shorter cells."""
    return (
        "a smaller solver.tolerance"
        if scene.time is not None and scene.solver.adapt
        else "more mesh.cells"
    )


def below_zero(problem: Problem, found: Least) -> str | None:
    """Return the warning about the least amount; None where it is within the errors
    that the scene allows.
    """
    time, limit = problem.scene.time, allowed(problem.scene)
    if not found.value < -limit:
        return None
    field = problem.unknowns[int(found.field)]
    of = "gas" if field.role is Role.GAS else "solids"
    when, key = "", "solver.tolerance"
    if time is not None:
        when, key = f" at t = {found.time:.4g} s", "time.tolerance"
    return (
        f"{field.species} falls to {found.value:.2g} of the {of} at x = "
        f"{found.x:.4g} m{when}, further below zero "
        f"than {key} = {limit:g}: use {finer(problem.scene)}, or a smaller {key}"
    )
